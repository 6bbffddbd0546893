"""relay, throttle and mux instead of those of topic_tools, and with the commands of topic_tools."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import STRING, Inbox, string
from interop.node_stage import Stage, stage_on
from programs import ROSTETHER, Peer
from waiting import until

DEBIAN_FOLDER = Path("/usr/lib/topic_tools")
ROLE_COMMAND = (*ROSTETHER, "role")

pytestmark = pytest.mark.topic_tools


@pytest_asyncio.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on("rostether's master", tmp_path) as stage:
        yield stage


def command(side: str, node: str) -> list[str]:
    return [*ROLE_COMMAND, node.replace("_", "-")] if side == "rostether" else [str(DEBIAN_FOLDER / node)]


async def start(stage: Stage, side: str, node: str, *arguments: str) -> Peer:
    return await stage.peers.start(*command(side, node), *arguments)


@pytest.mark.parametrize("side", ["rostether", "debian"])
async def test_a_mux_is_controlled_by_the_services_of_topic_tools(stage: Stage, side: str) -> None:
    peers = stage.peers

    async def call(service: str, *request: str, must_fail: bool = False) -> str:
        # Debian's rosservice has no Python classes of topic_tools' services.
        arguments = ("service", "call", f"/mux/{service}", *request)
        return await peers.run(*ROSTETHER, *arguments, check=not must_fail)

    for topic, text in (("/a", "from a"), ("/b", "from b")):
        await peers.start("rostopic", "pub", "-r", "10", topic, "std_msgs/String", text)
    await start(stage, side, "mux", "/out", "/a", "/b", "__name:=chooser")
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
    refused = await call("delete", "/b", must_fail=True)
    assert refused.startswith("rostether: error: ")
    types = {
        each: (await peers.run("rosservice", "type", f"/mux/{each}")).strip() for each in ("select", "list")
    }
    assert types == {"select": "topic_tools/MuxSelect", "list": "topic_tools/MuxList"}


@pytest.mark.parametrize("side", ["rostether", "debian"])
async def test_a_relay_and_a_throttle(stage: Stage, side: str) -> None:
    peers = stage.peers
    await peers.start("rostopic", "pub", "-r", "50", "/a", "std_msgs/String", "x")
    await start(stage, side, "relay", "/a", "/copy")
    await start(stage, side, "throttle", "messages", "/a", "5.0")
    node = await stage.join("/listener")
    began_s = time.monotonic()
    inboxes = {topic: Inbox() for topic in ("/a", "/copy", "/a_throttle")}
    for topic, inbox in inboxes.items():
        await node.subscribe(topic, STRING, inbox.store)
    await until(lambda: len(inboxes["/copy"].payloads) >= 50 and len(inboxes["/a_throttle"].payloads) >= 3)
    count = len(inboxes["/a_throttle"].payloads)
    assert count <= 5.0 * (time.monotonic() - began_s) + 1
    # Counts, not rates: 50 Hz on a quiet machine is slower on a busy one.
    assert count < len(inboxes["/a"].payloads)
    assert set(inboxes["/copy"].payloads + inboxes["/a_throttle"].payloads) == {string("x")}
    listed = (await peers.run("rosnode", "list")).split()
    assert any(name.startswith("/a_relay_") for name in listed)
    assert any(name.startswith("/a_throttle_") for name in listed)
