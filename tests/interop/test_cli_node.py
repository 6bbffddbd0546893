"""`rostether node` compared with rosnode."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio

from contract.graphs import STRING
from interop.node_stage import ON_BOTH_MASTERS, Stage, stage_on
from interop.side_by_side import SideBySide
from rostether.ros1.node.master_client import MasterClient
from waiting import until

TALKER = """
import rospy
from std_msgs.msg import String
rospy.init_node("talker")
publisher = rospy.Publisher("/chatter", String, queue_size=1, latch=True)
subscriber = rospy.Subscriber("/orders", String, lambda message: None)
publisher.publish("hello")
print("ready", flush=True)
rospy.spin()
print("over", flush=True)
"""


@pytest_asyncio.fixture
async def stage(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Stage]:
    async with stage_on(getattr(request, "param", "rostether's master"), tmp_path) as stage:
        yield stage


def without_times(text: str) -> str:
    return re.sub(r"\d+\.\d+ms", "#ms", text)


def sorted_lines(text: str) -> str:
    # rosnode pings in a random order.
    return "\n".join(sorted(without_times(text).splitlines()))


async def join_board(stage: Stage) -> None:
    """Join a node of rostether that is connected to the talker in both directions."""
    board = await stage.join("/lab/board")
    orders = await board.advertise("/orders", STRING)
    chatter = await board.subscribe("/chatter", STRING, lambda _: None)
    talker = await stage.peers.rospy(TALKER)
    await talker.wait_for("ready")
    await until(lambda: orders.subscriber_count == chatter.publisher_count == 1)
    await stage.wait_for_rosout("/lab/board", "/talker")


@ON_BOTH_MASTERS
async def test_nodes_print_the_same(stage: Stage) -> None:
    tools = SideBySide(stage.peers)
    await join_board(stage)

    listed, _, _, of_talker, of_board, *_ = await tools.assert_all_same(
        "rosnode",
        ("list",),
        ("list", "-a"),
        ("list", "-u", "lab"),
        ("info", "/talker"),
        ("info", "lab/board"),
        ("info", "-q", "/talker", "/lab/board"),
        ("machine",),
        ("machine", "localhost"),
    )
    assert {"/lab/board", "/talker"} <= set(listed.splitlines())
    # rospy does not describe its inbound connections, rostether does.
    for info, direction in ((of_talker, "outbound"), (of_board, "inbound")):
        assert re.search(rf" \* direction: {direction} \(\d+ - 127\.0\.0\.1:\d+\) \[\d+\]\n", info)
    await asyncio.gather(
        tools.assert_same("rosnode", "ping", "-c", "2", "talker", normalize=without_times),
        tools.assert_same("rosnode", "ping", "--all", normalize=sorted_lines),
    )
    assert "did you mean /talker?" in await tools.assert_both_fail("rosnode", "kill", "/talkr")


@ON_BOTH_MASTERS
async def test_kill_ends_a_rospy_node(stage: Stage) -> None:
    tools = SideBySide(stage.peers)
    talker = await stage.peers.rospy(TALKER)
    await talker.wait_for("ready")
    killed = await tools.run_rostether("rosnode", "kill", "/talker")
    assert (killed.code, killed.out, killed.err) == (0, "killing /talker\nkilled\n", "")
    await talker.wait_for("over")
    assert "/talker" not in (await tools.run_debian("rosnode", "list")).out


@ON_BOTH_MASTERS
async def test_cleanup_forgets_ended_nodes(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    # The check of nodes by rostether's master would remove it first.
    monkeypatch.setattr("rostether.ros1.master.node_calls._REFUSALS_UNTIL_GONE", 10**9)
    tools = SideBySide(stage.peers)
    master = MasterClient(stage.peers.master_uri, "/gone")
    await master.register_publisher("/chatter", STRING.name, "http://127.0.0.1:9/")
    await master.register_service("/reset", "rosrpc://127.0.0.1:9", "http://127.0.0.1:9/")
    await master.close()
    board = await stage.join("/board")
    cleaned = await tools.run_rostether("rosnode", "cleanup", stdin="y\n")
    assert cleaned.out.endswith("Unregistering /gone\ndone\n"), cleaned
    assert "/gone" not in (await tools.assert_same("rosnode", "list")).splitlines()
    assert "/reset" not in (await tools.run_debian("rosservice", "list")).out
    assert board.node_name in (await tools.run_debian("rosnode", "list")).out
