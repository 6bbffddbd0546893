"""The sensing platform's nodes with Debian's rospy and rostopic."""

from __future__ import annotations

import asyncio
import io
import xmlrpc.client
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from PIL import Image

from interop.node_stage import Stage, stage_on
from interop.ros1_peers import DEBIAN_PYTHON
from programs import ROSTETHER
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from unit.platform.datagrams import PlainReceiver, loopback_group

ROLE_COMMAND = (*ROSTETHER, "role")
CLIENT = Path(__file__).parent / "peers" / "register_sensor.py"

pytestmark = pytest.mark.ros1


@pytest_asyncio.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on("rostether's master", tmp_path) as stage:
        yield stage


async def test_a_sensor_node_of_rospy_registers_again(stage: Stage, tmp_path: Path) -> None:
    graph = TypedGraph(await stage.join("/viewer"), TypeStore(Registry()))
    await stage.peers.start(*ROLE_COMMAND, "sensing-manager", f"_state_file:={tmp_path / 'sensors.json'}")
    for _ in range(2):
        client = await stage.peers.start(DEBIAN_PYTHON, str(CLIENT), "Robot3")
        await client.wait_for("registered for sensor_node0")
        await wait_for_state(graph, "ready")
        assert (await graph.wait_for_message("/sensor_node0", timeout_s=60)).data == 42.0
        await client.stop()
        await wait_for_state(graph, "disconnected")


async def test_rostopic_shows_the_camera(stage: Stage) -> None:
    # The parameter of the original camera node; rostether's clients cannot set it.
    with xmlrpc.client.ServerProxy(stage.peers.master_uri) as server:
        await asyncio.to_thread(server.setParam, "/t", "/Robot3-pi_camera/vflip", True)
    camera = await stage.peers.start(
        *ROLE_COMMAND, "camera", "_source:=test", "_platform_name:=Robot3", "_id:=front"
    )
    await camera.wait_for("not registered as Robot3/front yet: no node offers")
    topic = "/sensors/Robot3/front"
    echo = await stage.peers.start("rostopic", "echo", "-n", "1", "--noarr", topic)
    await echo.wait_for('format: "jpeg"')
    graph = TypedGraph(await stage.join("/viewer"), TypeStore(Registry()))
    message = await graph.wait_for_message(topic, timeout_s=60)
    with Image.open(io.BytesIO(message.data)) as image:
        # In a picture that is not flipped, the bars are at the top; the first bar is white.
        assert image.convert("L").getpixel((8, 470)) == 255


async def wait_for_state(graph: TypedGraph, state: str) -> None:
    """Wait until the manager's list has one sensor with this state."""
    async with asyncio.timeout(60):
        async for message in graph.messages("/sensors", "sensing_platform/Sensors"):
            if [(each.platform_name, each.state) for each in message.sensors] == [("Robot3", state)]:
                return


async def test_a_topic_of_rostopic_as_bare_datagrams(stage: Stage) -> None:
    address = loopback_group()
    receiver = PlainReceiver(address)
    bridge = await stage.peers.start(
        *ROLE_COMMAND,
        "multicast-topic-bridge",
        "_topic:=joy_text",
        f"_mulicast_group_addr:={address.group}",
        f"_sending_port:={address.port}",
        "_interface:=lo",
    )
    await bridge.wait_for("sending /joy_text to 239.255.82.83:")
    await stage.peers.start("rostopic", "pub", "-r", "10", "/joy_text", "std_msgs/String", "x")
    async with asyncio.timeout(60):
        while not receiver.datagrams:
            await asyncio.sleep(0.01)
    receiver.close()
    assert set(receiver.datagrams) == {b"\1\0\0\0x"}
