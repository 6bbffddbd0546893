"""A Mega with a sketch is a ROS 2 node: rclpy in another process uses it over DDS."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from firmware.examples.stage import EXAMPLES
from firmware.ros2.mirrored import MIRROR, MIRRORED, NAMES
from firmware.ros2.serving import serving, sim_address
from interop_ros2.rclpy_peer import RclpyPeer, rclpy_peer
from interop_ros2.samples import ADDED, ros2_name
from programs import Peer
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions

pytestmark = [pytest.mark.rclpy, pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(300)]

TIMEOUT_S = 60.0
WARN = 30
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.fixture(scope="module")
def peer() -> Iterator[RclpyPeer]:
    """A node of rclpy, without rostether."""
    with rclpy_peer() as peer:
        yield peer


@pytest_asyncio.fixture(scope="module", loop_scope="module", autouse=True)
async def bridge(peer: RclpyPeer, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Peer]:
    """The bridge with the boards `/lab/arm` and `/lab/counter`, one for all tests."""
    address = await sim_address(MIRROR, "mega", "arm")
    folder = tmp_path_factory.mktemp("counter")
    counter = await counting_sketch(folder)
    boards = (f"{address}&ns=lab", f"sim:{counter}?board=uno&name=counter&ns=lab")
    async with serving("--ros2", "rclpy", "--msg-path", str(folder), *boards) as bridge:
        yield bridge


async def counting_sketch(folder: Path) -> Path:
    """Build the example ActionServer for an Uno, with an action that the peer's ROS 2 has."""
    definition = folder / "test_msgs" / "action" / "Fibonacci.action"
    definition.parent.mkdir(parents=True)
    definition.write_text("int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n")
    sketch = folder / "Counter" / "Counter.ino"
    sketch.parent.mkdir()
    example = (EXAMPLES / "ActionServer" / "ActionServer.ino").read_text()
    sketch.write_text(example.replace("actionlib_tutorials", "test_msgs"))
    built = await build_sketch(sketch, find_board("uno"), BuildOptions(msg_paths=(folder,), warnings=True))
    return built.elf


async def ask_until(ask: Callable[[], Awaitable[Any]], condition: Callable[[Any], object]) -> Any:
    """Ask until the answer meets a condition, and return it."""
    answer = None
    deadline_s = asyncio.get_running_loop().time() + TIMEOUT_S
    while not condition(answer := await ask()):
        assert asyncio.get_running_loop().time() < deadline_s, f"the last answer was {answer}"
        await asyncio.sleep(0.05)
    return answer


async def publish_until_received(
    peer: RclpyPeer, topic: str, publish: Callable[[], Awaitable[Any]]
) -> list[Any]:
    """Publish until the board's message arrives, because its publisher may be discovered later."""

    async def ask() -> list[Any]:
        received: list[Any] = await peer.ask("receive", topic=topic, count=0)
        if not received:
            await publish()
            await asyncio.sleep(0.2)
        return received

    found: list[Any] = await ask_until(ask, bool)
    return found


@pytest.mark.parametrize("name", NAMES)
async def test_messages_reach_the_board_and_come_back(peer: RclpyPeer, name: str) -> None:
    short = name.partition("/")[2]
    input_topic, output_topic = f"/lab/in_{short}", f"/lab/out_{short}"
    await peer.ask("subscribe", topic=output_topic, type=ros2_name(name))
    await peer.ask("advertise", topic=input_topic, type=ros2_name(name))

    async def publish() -> None:
        await peer.ask("publish", topic=input_topic, messages=[MIRRORED[name]])

    received = await publish_until_received(peer, output_topic, publish)
    assert received[0] == {**MIRRORED[name], **ADDED.get(name, {})}


async def test_the_board_answers_calls(peer: RclpyPeer) -> None:
    for data, message in ((True, "on"), (False, "off")):
        answered = await peer.ask(
            "call", service="/lab/switch", type="std_srvs/srv/SetBool", request={"data": data}
        )
        assert answered == {"success": data, "message": message}
    answered = await peer.ask("call", service="/lab/pull", type="std_srvs/srv/Trigger", request={})
    assert answered == {"success": True, "message": "bang"}


async def test_the_board_serves_an_action(peer: RclpyPeer) -> None:
    action = {"action": "/lab/fibonacci", "type": "test_msgs/action/Fibonacci"}
    succeeded = await peer.ask("send_goal", **action, goal={"order": 3})
    assert (succeeded["status"], succeeded["result"]) == (SUCCEEDED, {"sequence": [0, 1, 1, 2]})
    # On a busy machine, the board continues to count until the cancel arrives, perhaps to the end.
    canceled = await ask_until(
        lambda: peer.ask("send_goal", **action, goal={"order": 19}, cancel=True),
        lambda answer: answer["status"] == CANCELED,
    )
    assert canceled["feedback"][0]["sequence"][:3] == [0, 1, 1]
    assert canceled["result"]["sequence"][:3] == [0, 1, 1]
    refused = await peer.ask("send_goal", **action, goal={"order": 40})
    assert (refused["status"], refused["result"]) == (ABORTED, {"sequence": []})


async def test_the_board_calls_services(peer: RclpyPeer) -> None:
    gripper_response = {"success": True, "message": "gripped"}
    await peer.ask("serve", service="/lab/gripper", type="std_srvs/srv/SetBool", response=gripper_response)
    horn_response = {"success": True, "message": "honked"}
    await peer.ask("serve", service="/lab/horn", type="std_srvs/srv/Trigger", response=horn_response)
    await peer.ask("subscribe", topic="/lab/answers", type="std_msgs/msg/String")
    await peer.ask("advertise", topic="/lab/call", type="std_msgs/msg/Empty")
    await ask_until(lambda: peer.ask("endpoints", topic="/lab/answers"), lambda found: len(found) == 2)
    await peer.ask("publish", topic="/lab/call", messages=[{}])
    answers = await peer.ask("receive", topic="/lab/answers", count=2)
    assert answers == [{"data": "gripped"}, {"data": "honked"}]
    assert await peer.ask("received_requests", service="/lab/gripper") == [{"data": True}]


async def test_the_board_reads_its_parameters_and_logs(peer: RclpyPeer) -> None:
    await peer.ask("subscribe", topic="/rosout", type="rcl_interfaces/msg/Log", quality="rosout")
    await peer.ask("subscribe", topic="/lab/parameters", type="sensor_msgs/msg/JointState")
    await peer.ask("advertise", topic="/lab/read", type="std_msgs/msg/Empty")
    await ask_until(lambda: peer.ask("endpoints", topic="/lab/parameters"), lambda found: len(found) == 2)
    result = await peer.ask(
        "parameters",
        node="/lab/arm",
        method="set_parameters",
        arguments=[("gains", [0.5, 0.25]), ("count", 42), ("side", "left")],
    )
    assert [each["successful"] for each in result["results"]] == [True] * 3
    await peer.ask("publish", topic="/lab/read", messages=[{}])
    (read,) = await peer.ask("receive", topic="/lab/parameters", count=1)
    assert (read["header"]["frame_id"], read["position"]) == ("left", [0.5, 0.25, 42.0])

    def is_logged(logs: list[Any]) -> bool:
        return ("parameters are read", WARN, "lab.arm") in [
            (log["msg"], log["level"], log["name"]) for log in logs
        ]

    await ask_until(lambda: peer.ask("receive", topic="/rosout", count=0), is_logged)


async def test_the_board_is_a_node_with_its_endpoints(peer: RclpyPeer) -> None:
    await ask_until(lambda: peer.ask("nodes"), lambda nodes: ["arm", "/lab"] in nodes)
    publishers = [[f"/lab/out_{name.partition('/')[2]}", [ros2_name(name)]] for name in NAMES]
    subscribers = [[f"/lab/in_{name.partition('/')[2]}", [ros2_name(name)]] for name in NAMES]
    services = [["/lab/switch", ["std_srvs/srv/SetBool"]], ["/lab/pull", ["std_srvs/srv/Trigger"]]]
    # They are discovered one by one.
    await ask_until(
        lambda: peer.ask("endpoints_of_node", name="arm", namespace="/lab"),
        lambda seen: all(
            each in seen[kind]
            for kind, expected in (
                ("publishers", publishers),
                ("subscribers", subscribers),
                ("services", services),
            )
            for each in expected
        ),
    )


@pytest.mark.parametrize("name", NAMES)
async def test_types_have_the_hashes_of_the_official_packages(peer: RclpyPeer, name: str) -> None:
    # One topic for each type: DDS may list a topic for a short time after its last publisher.
    publisher = f"/official/{name}"
    await peer.ask("advertise", topic=publisher, type=ros2_name(name))
    try:
        (official,) = await ask_until(
            lambda: peer.ask("endpoints", topic=publisher),
            lambda found: [each["type"] for each in found] == [ros2_name(name)],
        )
        for direction in ("in", "out"):
            topic = f"/lab/{direction}_{name.partition('/')[2]}"
            found = await ask_until(
                lambda: peer.ask("endpoints", topic=topic),  # noqa: B023 - awaited at once
                lambda found: "arm" in [each["node"] for each in found],
            )
            (endpoint,) = [each for each in found if each["node"] == "arm"]
            assert (endpoint["type"], endpoint["hash"]) == (ros2_name(name), official["hash"])
    finally:
        await peer.ask("unadvertise", topic=publisher)


async def test_best_effort_endpoints_connect_to_the_board(peer: RclpyPeer) -> None:
    kind = {"type": "sensor_msgs/msg/Range", "quality": "sensor"}
    await peer.ask("subscribe", topic="/lab/out_Range", into="sensor", **kind)
    await peer.ask("advertise", topic="/lab/in_Range", **kind)

    async def publish() -> None:
        await peer.ask("publish", topic="/lab/in_Range", messages=[MIRRORED["sensor_msgs/Range"]])

    received = await publish_until_received(peer, "sensor", publish)
    assert received[0] == {**MIRRORED["sensor_msgs/Range"], **ADDED["sensor_msgs/Range"]}
