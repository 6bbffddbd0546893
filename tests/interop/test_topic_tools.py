"""Our relay, throttle and mux in the place of topic_tools', and with its own commands."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from interop.node_stage import Stage, stage_on
from programs import Peer

THEIRS = Path("/usr/lib/topic_tools")
OURS = [sys.executable, "-m", "rostether", "role"]

pytestmark = pytest.mark.topic_tools


@pytest_asyncio.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on("our master", tmp_path) as stage:
        yield stage


def command(whose: str, node: str) -> list[str]:
    return [*OURS, node.replace("_", "-")] if whose == "ours" else [str(THEIRS / node)]


async def start(stage: Stage, whose: str, node: str, *arguments: str) -> Peer:
    return await stage.peers.start(*command(whose, node), *arguments)


@pytest.mark.parametrize("whose", ["ours", "theirs"])
async def test_a_mux_is_steered_by_the_services_of_topic_tools(stage: Stage, whose: str) -> None:
    peers = stage.peers

    async def call(service: str, *request: str, fails: bool = False) -> str:
        # Debian's rosservice has no Python classes of topic_tools' services.
        words = ("-m", "rostether", "service", "call", f"/mux/{service}", *request)
        return await peers.run(sys.executable, *words, check=not fails)

    for topic, text in (("/a", "from a"), ("/b", "from b")):
        await peers.start("rostopic", "pub", "-r", "10", topic, "std_msgs/String", text)
    await start(stage, whose, "mux", "/out", "/a", "/b", "__name:=chooser")
    out = await peers.start("rostopic", "echo", "/out")
    await out.wait_for("from a")
    selected = await peers.start("rostopic", "echo", "/mux/selected")
    await selected.wait_for("/a")
    assert (await peers.run("rosservice", "list")).split().count("/mux/select") == 1
    assert 'prev_topic: "/a"' in await call("select", "/b")
    await out.wait_for("from b")
    await selected.wait_for("/b")
    await call("add", "c")
    listed = await call("list")
    assert [line.strip() for line in listed.splitlines()] == ["topics:", "- /a", "- /b", "- /c"]
    await call("delete", "/c")
    refused = await call("delete", "/b", fails=True)
    assert refused.startswith("rostether: error: ")
    types = {
        each: (await peers.run("rosservice", "type", f"/mux/{each}")).strip() for each in ("select", "list")
    }
    assert types == {"select": "topic_tools/MuxSelect", "list": "topic_tools/MuxList"}


@pytest.mark.parametrize("whose", ["ours", "theirs"])
async def test_a_relay_and_a_throttle(stage: Stage, whose: str) -> None:
    peers = stage.peers
    await peers.start("rostopic", "pub", "-r", "50", "/a", "std_msgs/String", "x")
    await start(stage, whose, "relay", "/a", "/copy")
    await start(stage, whose, "throttle", "messages", "/a", "5.0")
    for topic, least, most in (("/copy", 40, 60), ("/a_throttle", 3, 6)):
        meter = await peers.start("rostopic", "hz", "-w", "20", topic)
        await meter.wait_for("average rate")
        await asyncio.sleep(0)
        rates = [float(line.split()[-1]) for line in meter.lines if line.startswith("average rate")]
        assert least <= rates[-1] <= most, (topic, meter.text)
        await meter.stop()
    listed = (await peers.run("rosnode", "list")).split()
    assert any(name.startswith("/a_relay_") for name in listed)
    assert any(name.startswith("/a_throttle_") for name in listed)
