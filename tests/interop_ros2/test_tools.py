"""The tools over rclpy as processes, with a plain rclpy node."""

from __future__ import annotations

import asyncio
import os
import sys
from typing import Any

import pytest

from interop_ros2.rclpy_peer import PEER_NAME, RclpyPeer
from ros2_domains import own_domain
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.types.message_text import MessageText, TextStyle
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeClasses
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.yaml_form import fill_message

TIMEOUT_S = 60.0


async def tool(*arguments: str, code: int = 0) -> str:
    """Run one command; return its output, or its error line if `code` is not 0."""
    own_domain()
    environment = {name: value for name, value in os.environ.items() if not name.startswith("RMW_")}
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rostether",
        *arguments,
        "--ros2",
        "rclpy",
        env=environment,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        async with asyncio.timeout(TIMEOUT_S):
            out, err = await process.communicate()
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    assert process.returncode == code, (arguments, out, err)
    return (err if code else out).decode()


async def test_listings(peer: RclpyPeer) -> None:
    await peer.ask("advertise", topic="/text", type="std_msgs/msg/String", quality="latched")
    await peer.ask("subscribe", topic="/numbers", type="std_msgs/msg/Int32")
    await peer.ask("serve", service="/enable", type="std_srvs/srv/Trigger", response={"success": True})
    # On a busy machine, a tool may end before it has discovered the peer.
    for _ in range(5):
        topics, nodes, services = await asyncio.gather(
            tool("topic", "list", "-t"), tool("node", "list"), tool("service", "list", "-t")
        )
        if all(name in f"{topics}{nodes}{services}" for name in ("/text", "/numbers", "/enable", PEER_NAME)):
            break
    node, info = await asyncio.gather(tool("node", "info", PEER_NAME), tool("topic", "info", "-v", "/text"))
    assert "/text [std_msgs/msg/String]" in topics.splitlines()
    assert "/numbers [std_msgs/msg/Int32]" in topics.splitlines()
    assert nodes == f"{PEER_NAME}\n"
    assert "    /numbers: std_msgs/msg/Int32\n  Publishers:\n" in node
    assert "    /enable: std_srvs/srv/Trigger\n" in node
    assert "/enable [std_srvs/srv/Trigger]" in services.splitlines()
    described = await peer.ask("describe_topic", topic="/text")
    # rclpy knows the depth of its own queue, which the network does not report to other nodes.
    for line in described["peer"].splitlines():
        if "History (Depth)" not in line:
            assert line in info.splitlines()


async def test_messages(peer: RclpyPeer) -> None:
    await peer.ask("advertise", topic="/pose", type="geometry_msgs/msg/PoseStamped", quality="latched")
    echoing = asyncio.ensure_future(tool("topic", "echo", "--once", "/pose"))
    await peer.ask("publish", topic="/pose", messages=[{"header": {"frame_id": "map"}}], subscribers=0)
    await peer.ask("subscribe", topic="/speed", type="geometry_msgs/msg/Twist")
    published = await tool("topic", "pub", "-1", "/speed", "geometry_msgs/msg/Twist", "{linear: {x: 2}}")
    assert "publishing #1: geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=2.0," in published
    (twist,) = await peer.ask("receive", topic="/speed", count=1)
    assert twist["linear"]["x"] == 2.0
    assert await echoing == (
        "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: map\n"
        "pose:\n  position:\n    x: 0.0\n    y: 0.0\n    z: 0.0\n"
        "  orientation:\n    x: 0.0\n    y: 0.0\n    z: 0.0\n    w: 1.0\n---\n"
    )


async def test_calls_and_parameters(peer: RclpyPeer) -> None:
    await peer.ask(
        "serve", service="/set_led", type="std_srvs/srv/SetBool", response={"success": True, "message": "on"}
    )
    await peer.ask("set_own_parameter", name="gain", value=1.5)
    called, gain, listed = await asyncio.gather(
        tool("service", "call", "/set_led", "std_srvs/srv/SetBool", "{data: true}"),
        tool("param", "get", PEER_NAME, "gain"),
        tool("param", "list", PEER_NAME, "--param-type"),
    )
    assert called.endswith("response:\nstd_srvs.srv.SetBool_Response(success=True, message='on')\n\n")
    assert await peer.ask("received_requests", service="/set_led") == [{"data": True}]
    assert gain == "Double value is: 1.5\n"
    assert "  gain (type: double)\n" in listed
    assert await tool("param", "set", PEER_NAME, "gain", "2.5") == "Set parameter successful\n"
    assert await peer.ask("get_own_parameter", name="gain") == 2.5
    # The parameter stays a double.
    await tool("param", "set", PEER_NAME, "gain", "2")
    assert isinstance(await peer.ask("get_own_parameter", name="gain"), float)
    refused = await tool("param", "set", PEER_NAME, "use_sim_time", "high", code=1)
    assert "Setting parameter failed: " in refused


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("std_msgs/msg/String", {"data": "it's"}),
        ("std_msgs/msg/Bool", {"data": True}),
        ("geometry_msgs/msg/PoseStamped", {"header": {"stamp": {"sec": 5}}}),
        ("sensor_msgs/msg/JointState", {"name": ["a"], "position": [0.5, 1e-9]}),
        ("sensor_msgs/msg/CompressedImage", {"data": [1, 2]}),
        ("diagnostic_msgs/msg/DiagnosticArray", {"status": [{"level": 2, "values": [{"key": "k"}]}]}),
        ("std_msgs/msg/ByteMultiArray", {"data": [1, 97]}),
        ("std_srvs/srv/SetBool_Request", {"data": True}),
    ],
)
def test_messages_are_shown_as_python_shows_them(name: str, fields: dict[str, Any]) -> None:
    pytest.importorskip("rclpy")
    from interop_ros2.rclpy_program import fill, find

    package, kind, short = name.split("/")
    parts = short.partition("_")
    message_class = find(f"{package}/{kind}/{parts[0]}")
    rclpy_message = fill((getattr(message_class, parts[2]) if parts[2] else message_class)(), fields)
    registry = NativeRegistry(Ros2Definitions(), Registry())
    definition = registry.ros2_message(name)
    codec = TypeStore(registry, NativeClasses(registry)).codec(
        definition.full_name.replace(f"/{kind}/", "/").replace("_R", "R")
    )
    value = fill_message(codec, [fields], now=Time)
    assert MessageText(registry.ros2_message, TextStyle()).python(value, definition) == repr(rclpy_message)


async def test_the_doctor_counts_the_nodes_of_the_graph(peer: RclpyPeer) -> None:
    printed = await tool("doctor")
    assert "ok: graph: " in printed
    assert "0 nodes" not in printed
