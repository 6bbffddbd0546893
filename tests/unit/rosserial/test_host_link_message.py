"""After a chunk of nothing but messages there is nothing to send and no timer to set."""

from __future__ import annotations

import random

import pytest

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


@pytest.mark.parametrize("seed", range(30))
def test_a_quiet_chunk_leaves_nothing_to_do(seed: int) -> None:
    rng = random.Random(seed)
    link, now_s = settled_link()
    pumped, _ = settled_link()
    quiet_chunks = 0
    for _ in range(400):
        now_s += rng.choice((0.001, 0.01, 0.3, 1.2))
        chunk = rng.choice(CHUNKS)
        due_s = link.get_timer()
        assert link.receive_data(chunk, now_s) == pumped.receive_data(chunk, now_s)
        pumped._pump(now_s)
        if link.is_quiet:
            quiet_chunks += 1
            later_s = link.get_timer()
            assert due_s is not None and later_s is not None and later_s >= min(due_s, now_s)
            assert pumped.data_to_send() == b""
        if due_s is not None and now_s >= due_s:
            assert link.handle_timer(now_s) == pumped.handle_timer(now_s)
        assert link.data_to_send() == pumped.data_to_send()
        assert link.get_timer() == pumped.get_timer()
        assert link.statistics == pumped.statistics
    assert quiet_chunks > 20


def test_only_messages_of_a_device_at_work_are_quiet() -> None:
    link, now_s = settled_link()
    for chunk, is_quiet in (
        (MESSAGE, True),
        (MESSAGE * 2, True),
        (MESSAGE + MESSAGE[:9], False),
        (MESSAGE[9:], True),
        (TIME, False),
        (MESSAGE + TIME, False),
        (frame(126, b"not announced"), False),
        (b"", False),
    ):
        link.receive_data(chunk, now_s)
        assert link.is_quiet is is_quiet, chunk


def test_a_message_after_doubt_is_not_quiet() -> None:
    link, now_s = settled_link()
    link.receive_data(MESSAGE, now_s)
    now_s += PROBE_AFTER_S + 0.01
    link.handle_timer(now_s)  # a probe: was it reset?
    link.receive_data(MESSAGE, now_s)
    assert not link.is_quiet
    link.receive_data(MESSAGE, now_s)
    assert link.is_quiet
    silent_s = now_s + SILENT_AFTER_S
    while now_s < silent_s:
        now_s = link.get_timer() or silent_s
        link.handle_timer(now_s)
    link.receive_data(MESSAGE, now_s)
    assert not link.is_quiet
    assert REQUEST in link.data_to_send()
