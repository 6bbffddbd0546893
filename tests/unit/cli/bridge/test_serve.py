"""`serve`, `core` and `demo` as processes: what they print, which master they join, and how they end."""

from __future__ import annotations

import asyncio
import re
import signal
import socket
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from interop.ros1_peers import free_port
from programs import TIMEOUT_S, started
from rostether import Device
from rostether.joining import join
from rostether.ros1.master.server import MasterServer

pytestmark = pytest.mark.slow


async def _until(condition: Callable[[], Awaitable[bool]]) -> None:
    async with asyncio.timeout(60):
        while not await condition():
            await asyncio.sleep(0.02)


async def test_is_the_master_when_there_is_none(tmp_path: Path) -> None:
    port = free_port()
    uri = f"http://localhost:{port}"
    async with started("serve", f"pty:{tmp_path}/board", ROS_MASTER_URI=uri) as serve:
        await serve.wait_for("Started a ROS master: ROS_MASTER_URI=http://127.0.0.1")
        async with join("looker", environ={"ROS_MASTER_URI": uri}) as graph:
            assert await graph.get_param("/rosdistro") == "noetic\n"
            assert "/rosout_agg" in (await graph.snapshot()).topics


async def test_joins_the_master_that_answers() -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("serve", "tcp://:0", ROS_MASTER_URI=master.uri) as serve:
            await serve.wait_for("Joining the ROS master at")
    finally:
        await master.close()


async def test_waits_for_a_chosen_master() -> None:
    port, board_port = free_port(), free_port()
    uri = f"http://localhost:{port}"
    async with started("serve", "--master", uri, f"tcp://:{board_port}?name=patient") as serve:
        await serve.wait_for("Waiting for boards")
        async with Device(f"tcp://127.0.0.1:{board_port}") as device:
            device.publisher("count", "std_msgs/UInt32")
            await serve.wait_for("waiting for it")
            master = await MasterServer.start(port=port)
            try:
                async with join("looker", environ={"ROS_MASTER_URI": uri}) as graph:

                    async def published() -> bool:
                        return "/count" in (await graph.snapshot()).topics

                    await _until(published)
            finally:
                await master.close()


async def test_port_of_something_else_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        async with started("serve", "tcp://:0", "--master-port", str(port)) as serve:
            text = await serve.finish()
    assert serve.process.returncode == 1
    assert f"{port}" in text.splitlines()[-1]
    assert text.splitlines()[-1].startswith("rostether: error: ")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
async def test_end_informs_the_board_and_leaves_the_graph(number: signal.Signals) -> None:
    master = await MasterServer.start(port=0)
    try:
        async with started("serve", "tcp://:0?name=arm", ROS_MASTER_URI=master.uri) as serve:
            await serve.wait_for("Waiting for boards on tcp://127.0.0.1:")
            port = serve.text.rpartition(":")[2].split()[0]
            async with Device(f"tcp://127.0.0.1:{port}") as device:
                device.publisher("count", "std_msgs/UInt32")
                await serve.wait_for("/arm: Setup publisher on count [std_msgs/UInt32]")
                await serve.wait_for("Note: publish buffer size is")
                await device.wait_connected(60.0)
                serve.process.send_signal(number)
                async with asyncio.timeout(60):
                    await serve.process.wait()
                    while device.connected:
                        await asyncio.sleep(0.01)
            assert serve.process.returncode == (130 if number == signal.SIGINT else 0)
        assert "/arm" not in master.api.registrations.nodes
    finally:
        await master.close()


async def test_each_change_of_state_shows_on_request(tmp_path: Path) -> None:
    port = free_port()
    async with started("serve", "-vv", "tcp://:0?name=arm", "--master-port", str(port)) as serve:
        await serve.wait_for("Waiting for boards on tcp://127.0.0.1:")
        board_port = serve.text.rpartition("tcp://127.0.0.1:")[2].split()[0]
        async with Device(f"tcp://127.0.0.1:{board_port}") as device:
            device.publisher("count", "std_msgs/UInt32")
            for line in (
                "<session of /arm on tcp 127.0.0.1:",
                "/arm: negotiation IDLE -> ASKED (ASK)",
                "/arm: speaks protocol version 2",
                "/arm: presence ABSENT -> PRESENT (SIGN)",
                "/arm: <publisher count [std_msgs/UInt32] id 200>: opening",
                "/arm: negotiation LISTENING -> SETTLED (ENOUGH)",
            ):
                await serve.wait_for(line)


async def test_listener_on_loopback_names_the_flag() -> None:
    port = str(free_port())
    async with started("serve", "tcp://:0", "--master-port", port) as serve:
        await serve.wait_for("--listen 0.0.0.0")


async def test_no_such_option_of_an_address() -> None:
    async with started("serve", "/dev/ttyACM0?bud=9600") as serve:
        text = await serve.finish()
    assert serve.process.returncode == 1
    assert "unknown option 'bud'" in text
    assert len(text.splitlines()) == 1


async def test_two_ways_to_the_master_are_one_too_many() -> None:
    arguments = ("--master", "http://localhost:11311", "--master-port", "11312")
    async with started("serve", "tcp://:0", *arguments) as serve:
        assert "give only one of them" in await serve.finish()


async def test_core_serves_its_uri() -> None:
    async with started("core", "--port", "0") as core:
        await core.wait_for("ROS_MASTER_URI=http://127.0.0.1:")
        uri = core.lines[0].partition("=")[2]
        async with join("looker", environ={"ROS_MASTER_URI": uri}) as graph:
            assert "/rosout" in (await graph.snapshot()).nodes


async def test_second_core_reports_the_port_in_use() -> None:
    master = await MasterServer.start(port=0)
    try:
        port = master.uri.rstrip("/").rpartition(":")[2]
        async with started("core", "--port", port) as core:
            text = await core.finish()
        assert core.process.returncode == 1
        assert port in text
    finally:
        await master.close()


async def test_demo_ends_by_itself_with_messages() -> None:
    uri = f"http://localhost:{free_port()}"
    # On a busy machine, no message may arrive so soon.
    for seconds in ("2", "20", "60"):
        async with started("demo", "--ros1", "--seconds", seconds, ROS_MASTER_URI=uri) as demo:
            text = await demo.finish(timeout_s=2 * TIMEOUT_S)
        if demo.process.returncode == 0:
            break
    assert demo.process.returncode == 0
    assert "Setup publisher on ultrasound [sensor_msgs/Range]" in text
    last = next(line for line in reversed(text.splitlines()) if "discarded" in line)
    assert re.search(r"ultrasound \d+\.\d Hz", last)
    assert last.endswith(" 0 discarded")
    assert "WARN" not in text
