"""The short way of a chunk that is one message leads to the same place as the long one."""

from __future__ import annotations

import random

import pytest

from rostether.rosserial.events import HostEvent, MessagesReceived
from rostether.rosserial.presence import PROBE_AFTER_S, SILENT_AFTER_S
from unit.rosserial.decoding import frame
from unit.rosserial.host_link_boards import BURST, REQUEST, TIME, settled_link

MESSAGE = frame(125, b"\x05\x00\x00\x00hello")
CHUNKS = [
    *[MESSAGE] * 6,
    frame(125, bytes(8)),
    MESSAGE * 2,
    MESSAGE[:5],
    MESSAGE[5:],
    MESSAGE[:-1] + b"?",
    frame(100, b""),
    frame(126, b"nobody announced it"),
    TIME,
    BURST,
    b"",
    b"noise",
]


def _as_events(message: tuple[int, bytes]) -> list[HostEvent]:
    return [MessagesReceived(message[0], [message[1]])]


@pytest.mark.parametrize("seed", range(30))
def test_both_ways_lead_to_the_same(seed: int) -> None:
    rng = random.Random(seed)
    short, now_s = settled_link()
    long, _ = settled_link()
    short_ways = 0
    for _ in range(400):
        now_s += rng.choice((0.001, 0.01, 0.3, 1.2))
        chunk = rng.choice(CHUNKS)
        due_s = short.get_timer()
        message = short.receive_message(chunk, now_s)
        short_ways += message is not None
        events = short.receive_data(chunk, now_s) if message is None else _as_events(message)
        assert events == long.receive_data(chunk, now_s)
        if due_s is not None and now_s >= due_s:
            assert short.handle_timer(now_s) == long.handle_timer(now_s)
        assert short.data_to_send() == long.data_to_send()
        assert short.get_timer() == long.get_timer()
        assert short.statistics == long.statistics
    assert short_ways > 20


def test_nothing_becomes_due_earlier_and_nothing_is_to_be_sent() -> None:
    link, now_s = settled_link()
    link.receive_data(MESSAGE, now_s)
    due_s = link.get_timer()
    assert due_s is not None
    assert link.receive_message(MESSAGE, now_s + 0.01) == (125, MESSAGE[7:-1])
    later_s = link.get_timer()
    assert later_s is not None and later_s >= due_s
    assert link.data_to_send() == b""


def test_a_message_after_doubt_takes_the_long_way() -> None:
    link, now_s = settled_link()
    link.receive_data(MESSAGE, now_s)
    now_s += PROBE_AFTER_S + 0.01
    link.handle_timer(now_s)  # a probe: was it reset?
    assert link.receive_message(MESSAGE, now_s) is None
    link.receive_data(MESSAGE, now_s)
    assert link.receive_message(MESSAGE, now_s) is not None
    now_s += SILENT_AFTER_S + 0.01
    link.handle_timer(now_s)
    assert link.receive_message(MESSAGE, now_s) is None
    assert REQUEST in link.data_to_send()


def test_not_after_the_end() -> None:
    link, now_s = settled_link()
    link.receive_data(MESSAGE, now_s)
    link.stop()
    assert link.receive_message(MESSAGE, now_s) is None
