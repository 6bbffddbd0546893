"""Hostile bytes cost a bounded amount of work, and the next good frame is still found."""

from __future__ import annotations

import random
from collections.abc import Callable
from struct import Struct

import pytest

from rostether.rosserial import frame_scan
from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.frame_decoder import (
    FALSE_STARTS_PER_S,
    MAX_SAVED_FALSE_STARTS,
    FrameDecoder,
    Frames,
    PayloadLimits,
)
from rostether.rosserial.frame_scan import FrameScanner, Patience

CHUNK_BYTES = 64 * 1024
LIMITS = {100: 512, 125: 512}
REFUSED_ABOVE: dict[int | None, int] = {None: 512}
GOOD = encode_frame(125, b"good")


def _header(topic_id: int, size: int) -> bytes:
    low, high = size & 0xFF, size >> 8
    return bytes((0xFF, 0xFE, low, high, 255 - (low + high) % 256, topic_id & 0xFF, topic_id >> 8))


def _dense(rng: random.Random) -> bytes:
    return _header(125, 400) * (CHUNK_BYTES // 7)


def _varied(rng: random.Random) -> bytes:
    return b"".join(_header(rng.randrange(300), rng.randrange(600)) for _ in range(CHUNK_BYTES // 7))


def _lengths(rng: random.Random) -> bytes:
    return b"".join(_header(0, rng.randrange(65536))[:5] for _ in range(CHUNK_BYTES // 5))


def _damaged(rng: random.Random) -> bytes:
    return (encode_frame(125, bytes(8))[:-1] + b"\1") * (CHUNK_BYTES // 16)


HOSTILE: list[Callable[[random.Random], bytes]] = [_dense, _varied, _lengths, _damaged]


@pytest.mark.parametrize("make", HOSTILE)
def test_the_cost_of_searches_is_limited_over_time(
    make: Callable[[random.Random], bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    false_starts = 0
    scan = FrameScanner.scan

    def counted(scanner: FrameScanner, *arguments: object) -> object:
        nonlocal false_starts
        result = scan(scanner, *arguments)  # type: ignore[arg-type]
        false_starts += result.false_starts
        return result

    monkeypatch.setattr(FrameScanner, "scan", counted)
    decoder = FrameDecoder(limits=PayloadLimits(LIMITS, REFUSED_ABOVE))
    rng = random.Random(3)
    now_s, seconds, chunks = 0.0, 2.0, 200
    discarded = 0
    noise = make(rng)
    for _ in range(chunks):
        now_s += seconds / chunks
        decoded = decoder.feed(noise, now_s)
        discarded += sum(len(item.data) for item in decoded if isinstance(item, FrameDiscarded))
    # The ends of the chunks are searched in addition to the limit.
    assert false_starts < MAX_SAVED_FALSE_STARTS + 2 * FALSE_STARTS_PER_S * seconds + chunks * 300
    assert discarded > chunks * CHUNK_BYTES * 0.9
    found = decoder.feed(GOOD * 2, now_s + 0.01)
    for _ in range(40):
        now_s += 0.05
        found += decoder.handle_timer(now_s)
    assert any(isinstance(item, Frames) and b"good" in item.payloads for item in found)


@pytest.mark.parametrize("make", HOSTILE)
def test_a_frame_at_the_end_of_a_hostile_chunk_is_found(make: Callable[[random.Random], bytes]) -> None:
    decoder = FrameDecoder(limits=PayloadLimits(LIMITS, REFUSED_ABOVE))
    rng = random.Random(4)
    noise = make(rng)
    for turn in range(50):
        decoder.feed(noise, turn * 0.001)
    found = decoder.feed(bytes(600) + noise + bytes(600) + GOOD, 0.051)
    found += decoder.abandon(0.06)
    assert any(isinstance(item, Frames) and b"good" in item.payloads for item in found)


@pytest.mark.parametrize("make", [_dense, _varied, _damaged])
def test_a_line_that_was_quiet_is_searched_completely(make: Callable[[random.Random], bytes]) -> None:
    decoder = FrameDecoder(limits=PayloadLimits(LIMITS, REFUSED_ABOVE))
    noise = make(random.Random(5))[: MAX_SAVED_FALSE_STARTS * 6] + bytes(600)
    found = decoder.feed(noise[:30_000] + bytes(600) + GOOD + noise[30_000:], 0.0)
    found += decoder.abandon(0.1)
    assert any(isinstance(item, Frames) and b"good" in item.payloads for item in found)


def test_every_byte_is_reported_if_the_middle_is_not_searched() -> None:
    noise = _varied(random.Random(6)) + GOOD
    scan = FrameScanner(2, 65535, REFUSED_ABOVE).scan(noise, Patience.NONE, 10)
    assert sum(len(item.data) for item in scan.discarded) + len(GOOD) == len(noise)
    assert scan.groups == {125: [b"good"]}
    assert scan.false_starts < 400


def test_headers_that_occur_once_need_no_layout(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def counted(layout: str) -> Struct:
        made.append(layout)
        return Struct(layout)

    monkeypatch.setattr(frame_scan, "Struct", counted)
    decoder = FrameDecoder()
    frames = [encode_frame(300 + number, bytes(5000 + number)) for number in range(200)]
    decoded = decoder.feed(b"".join(frames), 0.0)
    assert [item.topic_id for item in decoded if isinstance(item, Frames)] == [*range(300, 500)]
    assert made == []
    decoder.feed(frames[0] * 3 + frames[1], 0.1)
    assert len(made) == 1
