"""Standard nodes as `rostether role` and `rostether run` start them."""

from __future__ import annotations

import asyncio
import os
import struct
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from interop.ros1_peers import free_port
from programs import started
from rostether import Device
from rostether.cli.bridge.rosserial_hosts import _serial_link, _socket_link, _udp_link
from rostether.cli.bridge.serial_node import name_options
from rostether.graph.typed_graph import TypedGraph
from rostether.joining import join
from rostether.ros1.master.server import MasterServer
from unit.cli.command_shell import Shell

pytestmark = pytest.mark.slow


@pytest_asyncio.fixture
async def master() -> AsyncIterator[MasterServer]:
    master = await MasterServer.start(port=0)
    try:
        yield master
    finally:
        await master.close()


@pytest_asyncio.fixture
async def graph(master: MasterServer) -> AsyncIterator[TypedGraph]:
    async with join("test", environ={"ROS_MASTER_URI": master.uri}) as graph:
        yield graph


async def appear(graph: TypedGraph, *nodes: str) -> None:
    async with asyncio.timeout(60):
        async for snapshot in graph.changes():
            if set(nodes) <= set(snapshot.nodes):
                return


async def publishes(graph: TypedGraph, node: str, topic: str) -> None:
    async with asyncio.timeout(60):
        async for snapshot in graph.changes():
            if topic in snapshot.topics and node in snapshot.topics[topic].publishers:
                return


async def test_a_relay_from_its_name_in_ros(master: MasterServer, graph: TypedGraph) -> None:
    talker = await graph.publisher("/lab/a", "std_msgs/String", latch=True)
    talker.publish(data="x")
    arguments = ("run", "topic_tools", "relay", "from", "to", "__name:=copier", "__ns:=/lab", "from:=a")
    async with started(*arguments, ROS_MASTER_URI=master.uri) as node:
        await appear(graph, "/lab/copier")
        assert (await graph.wait_for_message("/lab/to", timeout_s=60)).data == "x"
        # Another node takes its name: the process ends, so that a launch can start it again.
        async with join("/lab/copier", environ={"ROS_MASTER_URI": master.uri}):
            assert await asyncio.wait_for(node.process.wait(), 60) == 0


async def test_a_throttle_of_bytes(master: MasterServer, graph: TypedGraph) -> None:
    talker = await graph.publisher("/a", "std_msgs/String", latch=True)
    talker.publish(data="x")
    arguments = ("role", "throttle", "bytes", "/a", "100", "1.0", "__name:=slow", "_wall_clock:=true")
    async with started(*arguments, ROS_MASTER_URI=master.uri):
        assert (await graph.wait_for_message("/a_throttle", timeout_s=60)).data == "x"
        assert await graph.get_param("/slow/wall_clock") is True


async def test_a_mux_and_its_services(master: MasterServer, graph: TypedGraph) -> None:
    for name in ("/a", "/b"):
        (await graph.publisher(name, "std_msgs/String", latch=True)).publish(data=name)
    environ = {"ROS_MASTER_URI": master.uri}
    async with started("role", "mux", "/out", "/a", "_latch:=true", "__name:=chooser", **environ):
        assert (await graph.wait_for_message("/out", timeout_s=60)).data == "/a"
        for words in (("mux-add", "mux", "/b"), ("mux-select", "mux", "/b"), ("mux-delete", "mux", "/a")):
            async with started("role", *words, **environ) as command:
                assert await asyncio.wait_for(command.process.wait(), 60) == 0, command.lines
        async with started("role", "mux-list", "mux", **environ) as command:
            assert await asyncio.wait_for(command.process.wait(), 60) == 0
            await command.wait_for("/b")
            assert command.lines == ["/b"]
        async with started("role", "mux-select", "mux", "/c", **environ) as command:
            assert await asyncio.wait_for(command.process.wait(), 60) == 1
            await command.wait_for("/c is not an input; the inputs are /b")


async def test_a_joystick(master: MasterServer, graph: TypedGraph, tmp_path: Path) -> None:
    device = tmp_path / "js0"
    os.mkfifo(device)
    writer = os.open(device, os.O_RDWR)
    try:
        arguments = ("run", "joy", "joy_node", f"_dev:={device}", "_autorepeat_rate:=20")
        async with started(*arguments, ROS_MASTER_URI=master.uri) as node:
            await node.wait_for("Opened joystick")
            os.write(writer, struct.pack("<IhBB", 0, 1, 1, 3))
            async with asyncio.timeout(60):
                async for message in graph.messages("/joy"):
                    if list(message.buttons) == [0, 0, 0, 1]:
                        break
    finally:
        os.close(writer)


async def test_it_waits_for_the_master() -> None:
    port = free_port()
    uri = f"http://127.0.0.1:{port}"
    async with started("role", "relay", "/a", "__name:=copier", ROS_MASTER_URI=uri) as node:
        await node.wait_for("waiting for a ROS master at ")
        master = await MasterServer.start(port=port)
        try:
            async with join("test", environ={"ROS_MASTER_URI": uri}) as graph:
                await appear(graph, "/copier")
        finally:
            await master.close()


async def test_a_board_at_rosserial_server(master: MasterServer, graph: TypedGraph, tmp_path: Path) -> None:
    port = tmp_path / "ttyACM0"
    async with Device(f"pty:{port}") as device:
        device.publisher("chatter", "std_msgs/String")
        arguments = ("run", "rosserial_server", "serial_node", f"_port:={port}", "__name:=board")
        async with started(*arguments, ROS_MASTER_URI=master.uri) as node:
            await node.wait_for("Setup publisher on chatter")
            await publishes(graph, "/board", "/chatter")


async def test_boards_at_the_launch_file_of_rosserial_server(
    master: MasterServer, graph: TypedGraph, tmp_path: Path
) -> None:
    port = free_port()
    environ = {"ROS_MASTER_URI": master.uri, "ROS_LOG_DIR": str(tmp_path)}
    async with started("launch", "rosserial_server", "socket.launch", f"port:={port}", **environ) as launched:
        await launched.wait_for(
            "add _listen:=0.0.0.0 (with roslaunch, listen:=0.0.0.0) for boards on the network"
        )
        await launched.wait_for(f"Waiting for boards on tcp://127.0.0.1:{port}")
        async with Device(f"tcp://127.0.0.1:{port}") as device:
            device.publisher("chatter", "std_msgs/String")
            await launched.wait_for("Setup publisher on chatter")


def test_the_links_of_rosserial_server() -> None:
    name = name_options("/lab/board", "/lab")
    assert _serial_link([], {}, name) == "/dev/ttyACM0?name=board&ns=/lab"
    assert _serial_link([], {"port": "/dev/x", "baud": 9600}, name) == "/dev/x?name=board&ns=/lab&baud=9600"
    name = name_options("/b", "/")
    assert _socket_link([], {}, name) == "tcp://:11411?name=b"
    assert _udp_link([], {"server_port": 5}, name) == "udp://:5?name=b"
    wide = {"listen": "0.0.0.0"}
    assert _socket_link([], wide, name) == "tcp://0.0.0.0:11411?name=b"
    assert _udp_link([], wide, name) == "udp://0.0.0.0:11411?name=b"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("relay",), "write relay IN [OUT]; given: no arguments"),
        (("throttle", "messages", "/a", "fast"), "'fast' is not a number; write throttle messages IN HZ"),
        (("throttle", "words", "/a", "1"), "write throttle messages IN HZ"),
        (("throttle", "bytes", "/a", "1"), "write throttle messages IN HZ"),
        (("mux", "/out"), "write mux OUT IN..."),
        (("mux-list", "/a", "/b"), "write mux-list MUX; given: /a /b"),
    ],
)
def test_wrong_arguments_are_refused(shell: Shell, words: tuple[str, ...], reason: str) -> None:
    assert reason in shell.failure("role", *words)


async def test_a_relay_into_itself_is_refused(master: MasterServer) -> None:
    async with started("role", "relay", "/a", "/a", ROS_MASTER_URI=master.uri) as command:
        assert await asyncio.wait_for(command.process.wait(), 60) == 1
        await command.wait_for("/a would receive its own output")


def test_make_libraries(tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "ros_lib" in shell.output("role", "make-libraries", ".", "std_msgs")
    assert (tmp_path / "ros_lib" / "src" / "std_msgs" / "String.h").is_file()
    assert not (tmp_path / "ros_lib" / "src" / "sensor_msgs").exists()
    # As with rosserial's tool, a second run adds a package.
    shell.output("role", "make-libraries", ".", "std_srvs")
    assert {"std_msgs", "std_srvs"} <= {each.name for each in (tmp_path / "ros_lib" / "src").iterdir()}


async def test_nodes_leave_on_request(master: MasterServer, graph: TypedGraph) -> None:
    async with started("role", "relay", "/a", "__name:=copier", ROS_MASTER_URI=master.uri) as node:
        await appear(graph, "/copier")
        node.process.terminate()
        assert await asyncio.wait_for(node.process.wait(), 60) == 0
    names: set[str] = set((await graph.snapshot()).nodes)
    assert "/copier" not in names
