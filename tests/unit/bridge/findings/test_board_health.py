from __future__ import annotations

import asyncio

import pytest

from rostether.bridge.board_node import BoardNode
from rostether.bridge.findings.board_health import FORGET_AFTER_S, MAX_KEYS, FindingLedger
from rostether.bridge.findings.finding import Code, Finding, error, warning
from rostether.bridge.findings.resets import MIN_RESETS
from rostether.errors import PeerClosedError, TransportClosedError, TransportError
from rostether.rosserial.events import ProtocolDetected
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.transports.link_quality import RECENT_PACKETS, UNREACHED_PACKETS, LinkQuality
from unit.bridge.nodes import STORE, World


@pytest.mark.parametrize(
    ("ending", "is_program", "is_board"),
    [
        (TransportClosedError("the port is gone"), False, True),
        (TransportClosedError("tcp 127.0.0.1:1: Connection reset by peer"), True, False),
        (PeerClosedError("tcp 192.168.1.7:1 ended the connection"), False, False),
    ],
)
async def test_programs_that_follow_each_other_share_no_reset_history(
    ending: TransportError, is_program: bool, is_board: bool
) -> None:
    world = await World().open()
    health = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time).health
    now_s = 100.0
    for _ in range(MIN_RESETS + 1):
        watch = health.connected(None, LinkStatistics(), now_s)
        watch.handle_event(ProtocolDetected(2), now_s)
        assert watch.was_alive
        now_s += 1.0
        health.disconnected(ending, is_program=is_program)
    health.connected(None, LinkStatistics(), now_s)
    assert (Code.RESET_LOOP in {each.code for each in health.find(now_s)}) is is_board


async def test_the_finding_of_a_radio_names_the_last_packet_that_was_lost() -> None:
    world = await World().open()
    health = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time).health
    health.radio = LinkQuality(rssi_dbm=-71)
    for number in range(RECENT_PACKETS):
        is_lost = number % 2 == 0
        health.radio.count_sent("no acknowledgement" if is_lost else "delivered", is_lost=is_lost)
    health.connected(57600, LinkStatistics(), 0.0)
    (finding,) = health.find(1.0)
    assert finding.seen.startswith(
        "50 % of the last 50 radio packets to the board were lost (no acknowledgement, signal -71 dBm"
    )


async def test_a_board_that_no_radio_packet_reaches_is_found_soon() -> None:
    world = await World().open()
    health = BoardNode(world.board, STORE, world.reporter, asyncio.get_running_loop().time).health
    health.radio = LinkQuality()
    health.connected(57600, LinkStatistics(), 0.0)
    for number in range(1, UNREACHED_PACKETS + 1):
        assert health.find(1.0) == []
        health.radio.count_sent("no acknowledgement", is_lost=True)
        assert health.radio.lost_packets == number
    (finding,) = health.find(1.0)
    assert finding.seen == "100 % of the last 10 radio packets to the board were lost (no acknowledgement)"


def slow(late_ms: int = 100) -> Finding:
    return warning(Code.SLOW_LOOP, f"late by {late_ms} ms", "spin more often")


def test_a_finding_is_reported_once_while_it_lasts() -> None:
    ledger = FindingLedger()
    assert ledger.due([slow()], 0.0) == [slow()]
    for second in range(1, 600):
        assert ledger.due([slow(second)], float(second)) == []


def test_it_is_reported_again_when_it_comes_back_after_a_minute() -> None:
    ledger = FindingLedger()
    ledger.due([slow()], 0.0)
    assert ledger.due([slow()], FORGET_AFTER_S - 1) == []
    assert ledger.due([slow()], 2 * FORGET_AFTER_S) == [slow()]


def test_it_is_reported_again_when_it_gets_worse() -> None:
    ledger = FindingLedger()
    worse = error(Code.SLOW_LOOP, "late by 9 s", "spin more often")
    ledger.due([slow()], 0.0)
    assert ledger.due([worse], 1.0) == [worse]


def test_findings_of_several_subjects_are_all_reported() -> None:
    ledger = FindingLedger()
    both = [error(Code.BUFFER_TOO_SMALL, topic, "", topic) for topic in ("a", "b")]
    assert ledger.due(both[:1], 0.0) == both[:1]
    assert ledger.due(both, 1.0) == both[1:]


def test_invented_names_do_not_fill_the_memory() -> None:
    ledger = FindingLedger()
    for number in range(2 * MAX_KEYS):
        ledger.due([error(Code.NOT_BRIDGED, "", "", str(number))], 0.0)
    assert len(ledger._reported) == MAX_KEYS
