"""Boards with Debian's rostopic, rosservice and rosparam."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from firmware.examples.stage import TIMEOUT_S, running
from interop.ros1_peers import DEBIAN_PYTHON, Ros1Peers
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef import registry

pytestmark = [pytest.mark.ros1, pytest.mark.timeout(300)]

GENERATOR = Path("/usr/lib/genpy/gensrv_py.py")
TEST_SRV = Path(registry.__file__).parent / "share" / "rosserial_arduino" / "srv" / "Test.srv"


async def generate_types(folder: Path) -> Path:
    """Generate the class of rosserial_arduino/Test, which Debian does not package, with Debian's
    generator.
    """
    target = folder / "rosserial_arduino" / "srv"
    for action in (["-p", "rosserial_arduino", str(TEST_SRV)], ["--initpy", "-p", "rosserial_arduino"]):
        process = await asyncio.create_subprocess_exec(
            DEBIAN_PYTHON, str(GENERATOR), *action, "-o", str(target)
        )
        assert await process.wait() == 0
    (folder / "rosserial_arduino" / "__init__.py").touch()
    return folder


async def test_rostopic_pub_toggles_the_led(tmp_path: Path) -> None:
    async with running("Blink") as stage:
        peers = Ros1Peers(stage.master_uri, tmp_path)
        try:
            for level in (True, False):
                # It runs until the board subscribes; with -1 it would end after three seconds.
                publisher = await peers.start("rostopic", "pub", "/toggle_led", "std_msgs/Empty")
                await stage.board.wait_for_pin("D13", level, timeout_s=TIMEOUT_S)
                await publisher.stop()
        finally:
            await peers.close()


async def test_rosservice_call_is_answered(tmp_path: Path) -> None:
    types = await generate_types(tmp_path)
    async with running("ServiceServer") as stage:
        peers = Ros1Peers(stage.master_uri, tmp_path)
        peers.environment["PYTHONPATH"] = str(types)
        try:
            await stage.wait_for_service("/test_srv")
            assert "rosserial_arduino/Test" in await peers.run("rosservice", "type", "/test_srv")
            for reported in ("hello", "world"):
                printed = await peers.run("rosservice", "call", "/test_srv", "input: anybody there?")
                assert printed.strip() == f'output: "{reported}"'
        finally:
            await peers.close()


async def test_rosparam_set_is_read_and_rostopic_echo_shows_it(tmp_path: Path) -> None:
    async def set_gains(_graph: TypedGraph, master_uri: str) -> None:
        peers = Ros1Peers(master_uri, tmp_path)
        try:
            await peers.run("rosparam", "set", "/board/gains", "[1.5, 0.25, 0.5]")
            await peers.run("rosparam", "set", "/board/name", "lefty")
        finally:
            await peers.close()

    async with running("Parameters", prepare=set_gains) as stage:
        peers = Ros1Peers(stage.master_uri, tmp_path)
        try:
            await stage.message("/name", "std_msgs/String", lambda message: message.data == "lefty")
            printed = await peers.run("rostopic", "echo", "-n", "1", "/gains")
            assert "data: [1.5, 0.25, 0.5]" in printed
        finally:
            await peers.close()
