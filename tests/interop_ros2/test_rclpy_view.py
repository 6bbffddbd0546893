"""The graph as listed by a node of rostether over rclpy and by a plain rclpy node in another process."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path

import pytest

from contract.graphs import Inbox, answer
from interop_ros2.rclpy_peer import PEER_NAME, RclpyPeer
from ros2_domains import own_domain
from rostether.errors import UnknownTypeError
from rostether.graph.ports import JoinGraph
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.endpoint_info import find_distribution
from rostether.ros2.rclpy.context import RclpyContext
from rostether.ros2.type_description import SERVICE_TYPE, learn_type
from rostether.ros2.types.type_hash import message_hash, service_hash
from rostether.ros2.types.type_support import Ros2Types
from rostether.rostime import Time
from rostether.serde.store import TypeStore

pytestmark = [pytest.mark.rclpy, pytest.mark.asyncio(loop_scope="module")]


async def test_a_node_of_rclpy_describes_its_services(join: JoinGraph, peer: RclpyPeer) -> None:
    name, known = "std_srvs/srv/SetBool", Ros2Definitions()
    types = Ros2Types(Registry(), known)
    types.native_service(SERVICE_TYPE)
    types.definitions = Ros2Definitions(bundled=False)
    node = await join("/learner")
    await peer.ask("serve", service="/described", type=name, response={})
    type_hash = service_hash(known.service(name), known)
    while not types.definitions.has(name):
        with contextlib.suppress(UnknownTypeError):
            await learn_type(node, types, PEER_NAME, name, type_hash)
    learned = types.definitions.service(name)
    assert [(each.name, str(each.type)) for each in learned.response.fields] == [
        ("success", "bool"),
        ("message", "string"),
    ]
    await node.close()


async def test_rclpy_lists_nodes_with_their_endpoints(
    join: JoinGraph, peer: RclpyPeer, store: TypeStore
) -> None:
    node = await join("board", namespace="/robot", remappings={"chat": "/talk"})

    async def handle(_: bytes) -> bytes:
        return answer()

    await node.advertise("chat", store.registry.message_type("std_msgs/String"))
    await node.subscribe("~cmd", store.registry.message_type("geometry_msgs/Twist"), Inbox().store)
    await node.advertise_service("switch", store.registry.service_type("std_srvs/SetBool"), handle)
    while ["board", "/robot"] not in await peer.ask("nodes"):
        await asyncio.sleep(0.01)
    while True:
        seen = await peer.ask("endpoints_of_node", name="board", namespace="/robot")
        if len(seen["publishers"]) == 3 and len(seen["subscribers"]) == 1 and len(seen["services"]) == 8:
            break
        await asyncio.sleep(0.01)
    assert ["/talk", ["std_msgs/msg/String"]] in seen["publishers"]
    assert {topic for topic, _ in seen["publishers"]} == {"/talk", "/rosout", "/parameter_events"}
    assert seen["subscribers"] == [["/robot/board/cmd", ["geometry_msgs/msg/Twist"]]]
    assert ["/robot/switch", ["std_srvs/srv/SetBool"]] in seen["services"]
    endpoints = await peer.ask("endpoints", topic="/talk")
    assert [(each["reliability"], each["durability"]) for each in endpoints] == [("RELIABLE", "VOLATILE")]


async def test_nodes_of_rclpy_are_listed(join: JoinGraph, peer: RclpyPeer) -> None:
    node = await join("/board")
    changes = node.changes()
    await anext(changes)
    await peer.ask("advertise", topic="/seen", type="std_msgs/msg/String")
    while True:
        snapshot = await asyncio.wait_for(anext(changes), 60)
        if "/seen" in snapshot.topics:
            break
    assert PEER_NAME in snapshot.nodes
    assert await find_distribution(node, {}) == "kilted"
    assert await find_distribution(node, {"ROS_DISTRO": "jazzy"}) == "jazzy"
    assert snapshot.topics["/seen"].type == "std_msgs/msg/String"
    assert snapshot.topics["/seen"].publishers == (PEER_NAME,)
    assert snapshot.services[f"{PEER_NAME}/get_parameters"].providers == (PEER_NAME,)
    await peer.ask("unadvertise", topic="/seen")
    while "/seen" in snapshot.topics:
        snapshot = await asyncio.wait_for(anext(changes), 60)


async def test_rclpy_removes_a_node_that_leaves(join: JoinGraph, peer: RclpyPeer) -> None:
    node = await join("/leaver")
    while ["leaver", "/"] not in await peer.ask("nodes"):
        await asyncio.sleep(0.01)
    await node.close()
    while ["leaver", "/"] in await peer.ask("nodes"):
        await asyncio.sleep(0.01)


@pytest.mark.parametrize("name", ["sensor_msgs/msg/Imu", "diagnostic_msgs/msg/DiagnosticArray"])
async def test_a_node_of_rclpy_describes_its_types(join: JoinGraph, peer: RclpyPeer, name: str) -> None:
    known = Ros2Definitions()
    types = Ros2Types(Registry(), known)
    # The service's type stays known.
    types.native_service(SERVICE_TYPE)
    types.definitions = Ros2Definitions(bundled=False)
    node = await join("/learner")
    await peer.ask("advertise", topic="/described", type=name)
    type_hash = message_hash(known.message(name), known)
    while True:
        # The peer's service may not be announced yet.
        try:
            await learn_type(node, types, PEER_NAME, name, type_hash)
            break
        except UnknownTypeError as error:
            assert "no node offers" in str(error)
    learned = types.definitions.message(name)
    assert [(each.name, each.type) for each in learned.fields] == [
        (each.name, each.type) for each in known.message(name).fields
    ]
    assert types.by_name(name).type_hash == type_hash
    with pytest.raises(UnknownTypeError, match="it does not describe std_msgs/msg/Char"):
        await learn_type(node, types, PEER_NAME, "std_msgs/msg/Char", type_hash)
    with pytest.raises(UnknownTypeError, match="its node does not describe it: "):
        await learn_type(node, types, PEER_NAME, name, f"RIHS01_{'0' * 64}")
    await peer.ask("unadvertise", topic="/described")
    await node.close()


async def test_time_comes_from_clock_with_use_sim_time(join: JoinGraph, peer: RclpyPeer) -> None:
    node = await join("/simulated")
    await node.set_param("~use_sim_time", value=True)
    assert node.now() == Time()
    await peer.ask("advertise", topic="/clock", type="rosgraph_msgs/msg/Clock")
    # Best-effort messages are not sent again.
    while node.now() != Time(42, 7):
        await peer.ask("publish", topic="/clock", messages=[{"clock": {"sec": 42, "nanosec": 7}}])
        await asyncio.sleep(0.01)
    await node.set_param("~use_sim_time", value=False)
    assert node.now() > Time(1_000_000, 0)


async def test_parameters_from_a_file(store: TypeStore, tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(
        "/**:\n  ros__parameters:\n    gain: 0.5\n/robot/board:\n  ros__parameters:\n    arm: {p: 3}\n"
    )
    context = await RclpyContext.open(
        Ros2Types(store.registry, Ros2Definitions()),
        domain_id=own_domain(),
        arguments=["--ros-args", "--params-file", str(path)],
    )
    node, other = await context.join("board", namespace="/robot"), await context.join("/other")
    assert await node.get_param("~gain") == 0.5
    assert await node.get_param("~arm") == {"p": 3}
    assert await other.get_param("~gain") == 0.5
    assert not await other.has_param("~arm")
    await context.close()
