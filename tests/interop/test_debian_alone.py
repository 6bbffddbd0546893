"""Debian's programs work on this machine. If this fails, rostether is not the cause."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from interop.ros1_peers import Ros1Peers, free_port
from programs import TIMEOUT_S


@pytest.mark.roscpp
async def test_roscpp_publisher_to_rostopic_echo(roscore: Ros1Peers) -> None:
    await roscore.roscpp("latch", "/chatter", "over the line")
    assert "over the line" in await roscore.run("rostopic", "echo", "-n", "1", "/chatter")


async def test_the_replacement_of_roscore_offers_the_same(roscore: Ros1Peers, tmp_path: Path) -> None:
    port = free_port()
    other = Ros1Peers(f"http://localhost:{port}/", tmp_path / "other")
    try:
        core = await other.start("roscore", "-p", str(port))
        await core.wait_for("started core service [/rosout]")
        # rosout registers itself some time after its start.
        async with asyncio.timeout(TIMEOUT_S):
            while "/rosout_agg" not in await other.run("rostopic", "list", check=False):
                await asyncio.sleep(0.01)
        for command in (("rosnode", "list"), ("rostopic", "list", "-v"), ("rosservice", "list")):
            expected, replaced = await asyncio.gather(other.run(*command), roscore.run(*command))
            assert expected == replaced
        expected_names, names = await asyncio.gather(
            other.run("rosparam", "list"), roscore.run("rosparam", "list")
        )
        assert [
            name for name in expected_names.splitlines() if "/roslaunch/" not in name
        ] == names.splitlines()
    finally:
        await other.close()
