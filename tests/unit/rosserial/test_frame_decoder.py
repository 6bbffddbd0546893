from __future__ import annotations

import random
import time
from collections.abc import Callable

import pytest

from rostether.rosserial.events import DiscardReason, FrameDiscarded
from rostether.rosserial.frame_decoder import (
    FIRST_SEARCH_S,
    MAX_SEARCH_S,
    Decoded,
    FrameDecoder,
    Frames,
    PayloadLimits,
)
from unit.rosserial.decoding import (
    by_topic,
    discards,
    feed_byte_by_byte,
    feed_whole,
    frame,
    joined_discards,
    plain_decode,
)

A = frame(125, b"alpha")
B = frame(126, b"beta")
EMPTY = frame(100, b"")
TRAP = bytes.fromhex("fffe0300fc")  # boot noise that holds a valid header
A1 = frame(125, b"alpha", 1)

V2_REQUEST = bytes.fromhex("fffe0000ff0000")
HUGE = frame(125, bytes(50000))
BAD_CHECK = A[:-1] + b"?"
BAD_LENGTH = A[:4] + b"?" + A[5:]
BAD_BYTE = A[:9] + b"?" + A[10:]
INSERTED = A[:8] + b"x" + A[8:]
BAD_CHECK_1 = A1[:-1] + b"?"

# name, protocol version, bytes, messages by topic id, discarded (reason, bytes) in order
CASES: list[tuple[str, int, bytes, dict[int, list[bytes]], list[tuple[str, bytes]]]] = [
    ("one frame", 2, A, {125: [b"alpha"]}, []),
    ("a run of frames", 2, A * 3, {125: [b"alpha"] * 3}, []),
    ("two topics in turn", 2, A + B + A, {125: [b"alpha"] * 2, 126: [b"beta"]}, []),
    ("a frame without payload", 2, EMPTY * 2, {100: [b"", b""]}, []),
    ("large frame", 2, frame(9999, bytes(42000)), {9999: [bytes(42000)]}, []),
    ("text before", 2, b"Booting...\r\n" + A, {125: [b"alpha"]}, [("NOISE", b"Booting...\r\n")]),
    ("text between", 2, A + b"hm" + A, {125: [b"alpha"] * 2}, [("NOISE", b"hm")]),
    ("sync twice", 2, b"\xff" + A, {125: [b"alpha"]}, [("VERSION", b"\xff")]),
    ("a probe", 2, b"\xff\x00" + A, {125: [b"alpha"]}, [("VERSION", b"\xff\x00")]),
    ("probes are one stretch", 2, b"\xff\x00" * 3 + A, {125: [b"alpha"]}, [("VERSION", b"\xff\x00" * 3)]),
    ("version 1 frame", 2, A1 + A, {125: [b"alpha"]}, [("VERSION", A1)]),
    ("wrong payload check", 2, BAD_CHECK + B, {126: [b"beta"]}, [("PAYLOAD_CHECKSUM", BAD_CHECK)]),
    ("wrong length check", 2, BAD_LENGTH + B, {126: [b"beta"]}, [("LENGTH_CHECKSUM", BAD_LENGTH)]),
    ("wrong byte in a run", 2, A + BAD_BYTE + A, {125: [b"alpha"] * 2}, [("PAYLOAD_CHECKSUM", BAD_BYTE)]),
    ("header in noise", 2, TRAP + A, {125: [b"alpha"]}, [("PAYLOAD_CHECKSUM", TRAP)]),
    ("a frame cut short hides no other", 2, A[:-3] + B, {126: [b"beta"]}, [("PAYLOAD_CHECKSUM", A[:-3])]),
    ("one byte inserted", 2, INSERTED + B, {126: [b"beta"]}, [("PAYLOAD_CHECKSUM", INSERTED)]),
    ("longer than the limit", 2, HUGE + A, {125: [b"alpha"]}, [("TOO_LONG", HUGE)]),
    ("version 1", 1, A1 * 2, {125: [b"alpha"] * 2}, []),
    (
        "version 1, wrong check",
        1,
        BAD_CHECK_1 + A1,
        {125: [b"alpha"]},
        [("PAYLOAD_CHECKSUM", b"\xff"), ("VERSION", BAD_CHECK_1[1:])],
    ),
    ("version 2 request to version 1", 1, V2_REQUEST + A1, {125: [b"alpha"]}, [("VERSION", V2_REQUEST)]),
]
CASE_IDS = [case[0] for case in CASES]
LIMIT_BYTES = 45000


@pytest.mark.parametrize(("name", "version", "data", "messages", "discarded"), CASES, ids=CASE_IDS)
@pytest.mark.parametrize("feed", [feed_whole, feed_byte_by_byte])
def test_cases(
    name: str,
    version: int,
    data: bytes,
    messages: dict[int, list[bytes]],
    discarded: list[tuple[str, bytes]],
    feed: Callable[[FrameDecoder, bytes], list[Decoded]],
) -> None:
    decoder = FrameDecoder(version, max_payload_bytes=LIMIT_BYTES)
    decoded = feed(decoder, data)
    assert by_topic(decoded) == messages
    assert joined_discards(decoded) == discarded
    assert decoder.pending_bytes == 0


@pytest.mark.parametrize(("name", "version", "data", "messages", "discarded"), CASES, ids=CASE_IDS)
def test_cases_with_trailing_data(
    name: str,
    version: int,
    data: bytes,
    messages: dict[int, list[bytes]],
    discarded: list[tuple[str, bytes]],
) -> None:
    decoder = FrameDecoder(version, max_payload_bytes=LIMIT_BYTES)
    unfinished = frame(131, b"more", version)
    first = decoder.feed(data + unfinished[:-2], 0.0)
    assert by_topic(first) == messages
    assert joined_discards(first) == discarded
    assert decoder.pending_bytes == len(unfinished) - 2
    assert by_topic(decoder.feed(unfinished[-2:], 0.1)) == {131: [b"more"]}


def test_one_group_for_each_topic_of_a_chunk() -> None:
    decoded = FrameDecoder().feed((A + B) * 5, 0.0)
    assert decoded == [Frames(125, [b"alpha"] * 5), Frames(126, [b"beta"] * 5)]


def test_invalid_headers_are_rejected_immediately() -> None:
    decoder = FrameDecoder()
    assert decoder.feed(b"\xff", 0.0) == []
    assert decoder.feed(b"\x00", 0.0) == [FrameDiscarded(DiscardReason.VERSION, b"\xff\x00")]
    assert decoder.feed(b"\xff\xfe\x01\x02", 0.0) == []
    assert decoder.feed(b"\x03", 0.0) == [
        FrameDiscarded(DiscardReason.LENGTH_CHECKSUM, b"\xff\xfe\x01\x02\x03")
    ]


def test_takes_any_bytes_like_object() -> None:
    for data in (A, bytearray(A), memoryview(A)):
        assert FrameDecoder().feed(data, 0.0) == [Frames(125, [b"alpha"])]


def test_random_traffic_as_a_plain_decoder_reads_it() -> None:
    rng = random.Random(4)
    for version in (1, 2):
        line = b"".join(
            rng.choice((b"", b"", b"text", rng.randbytes(4).replace(b"\xff", b"x")))
            + frame(rng.randrange(100, 110), rng.randbytes(rng.choice((0, 4, 64, 300, 700))), version)
            for _ in range(400)
        )
        expected: dict[int, list[bytes]] = {}
        for topic_id, payload in plain_decode(line, version):
            expected.setdefault(topic_id, []).append(payload)
        assert by_topic(FrameDecoder(version).feed(line, 0.0)) == expected


def test_every_single_damaged_byte_is_caught() -> None:
    payload = bytes(range(20))
    whole = frame(125, payload)
    for position in range(2, len(whole)):
        for change in (1, 0x80, 0xFF):
            damaged = bytearray(whole)
            damaged[position] ^= change
            assert payload not in by_topic(FrameDecoder().feed(bytes(damaged) + bytes(70000), 0.0)).get(
                125, []
            )


class TestUnfinishedFrames:
    CLAIM = frame(777, bytes(60000))[:20]

    def test_noise_that_claims_a_large_length_delays_the_next_frames_only_briefly(self) -> None:
        decoder = FrameDecoder(limits=PayloadLimits({125: 100}))
        assert decoder.feed(self.CLAIM + A + A, 10.0) == []
        due_s = decoder.get_timer()
        assert due_s is not None
        assert due_s == pytest.approx(10.0 + FIRST_SEARCH_S)
        assert decoder.handle_timer(due_s - 0.01) == []
        assert decoder.handle_timer(due_s) == [
            Frames(125, [b"alpha"] * 2),
            FrameDiscarded(DiscardReason.UNFINISHED, self.CLAIM),
        ]
        assert decoder.get_timer() is None

    def test_even_while_bytes_keep_flowing(self) -> None:
        decoder = FrameDecoder(limits=PayloadLimits({125: 100}))
        decoder.feed(self.CLAIM, 0.0)
        found: list[Decoded] = []
        now_s = 0.0
        while not by_topic(found):
            now_s += 0.02
            found += decoder.feed(A, now_s)
            found += decoder.handle_timer(now_s)
        assert now_s <= FIRST_SEARCH_S + 0.03
        assert by_topic(found)[125] == [b"alpha"] * round(now_s / 0.02)

    def test_a_possible_frame_is_waited_for_while_its_bytes_flow(self) -> None:
        decoder = FrameDecoder(limits=PayloadLimits({125: 4000}))
        embedded = frame(125, (b"x" + A) * 200)
        found: list[Decoded] = []
        for position in range(0, len(embedded), 10):
            now_s = position * 0.002
            found += decoder.feed(embedded[position : position + 10], now_s)
            found += decoder.handle_timer(now_s)
        assert by_topic(found) == {125: [(b"x" + A) * 200]}
        assert not discards(found)

    def test_a_slow_network_may_still_deliver_the_rest(self) -> None:
        decoder = FrameDecoder(limits=PayloadLimits({125: 1000}))
        whole = frame(125, bytes(500))
        assert decoder.feed(whole[:300], 0.0) == []
        due_s = decoder.get_timer()
        assert due_s is not None
        assert decoder.handle_timer(due_s) == []
        assert decoder.get_timer() is None
        assert decoder.feed(whole[300:], 30.0) == [Frames(125, [bytes(500)])]

    def test_looks_get_rarer_but_never_rarer_than_the_bound(self) -> None:
        decoder = FrameDecoder(limits=PayloadLimits({125: 100}))
        decoder.feed(self.CLAIM, 0.0)
        now_s = 0.0
        gaps: list[float] = []
        while len(gaps) < 10:
            decoder.feed(b"\x00", now_s)
            due_s = decoder.get_timer()
            assert due_s is not None
            gaps.append(due_s - now_s)
            now_s = due_s
            assert decoder.handle_timer(now_s) == []
        assert gaps == sorted(gaps)
        assert gaps[-1] == pytest.approx(MAX_SEARCH_S)

    def test_frames_inside_on_impossible_ids_do_not_end_a_frame(self) -> None:
        decoder = FrameDecoder(limits=PayloadLimits({125: 100}))
        decoder.feed(self.CLAIM + B, 0.0)
        assert decoder.handle_timer(1.0) == []

    def test_abandon_returns_the_frames_inside(self) -> None:
        decoder = FrameDecoder()
        decoder.feed(self.CLAIM + A + B[:-1], 0.0)
        assert decoder.abandon(0.0) == [
            Frames(125, [b"alpha"]),
            FrameDiscarded(DiscardReason.UNFINISHED, self.CLAIM),
            FrameDiscarded(DiscardReason.UNFINISHED, B[:-1]),
        ]
        assert decoder.pending_bytes == 0

    def test_a_device_abandons_after_a_pause(self) -> None:
        decoder = FrameDecoder(abandon_after_s=0.25)
        decoder.feed(b"\xff", 0.0)
        assert decoder.get_timer() == 0.25
        assert decoder.handle_timer(0.25) == [FrameDiscarded(DiscardReason.UNFINISHED, b"\xff")]

    def test_reports_which_frame_is_incomplete(self) -> None:
        decoder = FrameDecoder()
        decoder.feed(A[:-1], 1.0)
        assert decoder.is_receiving({125}, 1.01)
        assert not decoder.is_receiving({126}, 1.01)
        assert not decoder.is_receiving({125}, 1.2)


CLAIMS_60000 = frame(125, bytes(60000))[:7]
CLAIMS_600 = frame(125, bytes(600))[:7]
HOSTILE = {
    "syncs": b"\xff\xfe" * 32768,
    "first bytes": b"\xff" * 65536,
    "probes": b"\xff\x00" * 32768,
    "long claims": CLAIMS_60000 * 9362,
    "short claims": CLAIMS_600 * 9362,
    "claims with frames between": (CLAIMS_60000 + A) * 3000,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_bytes_take_linear_time(name: str) -> None:
    # A quadratic rescan of these needs many seconds; the limit is sufficient on a busy machine.
    data = HOSTILE[name]
    decoder = FrameDecoder()
    began_s = time.process_time()
    decoded = [item for now in range(4) for item in decoder.feed(data, now)]
    for now in range(4, 10):
        decoded += decoder.handle_timer(now)
    assert time.process_time() - began_s < 5
    assert sum(len(item.data) for item in discards(decoded)) <= 4 * len(data)


def test_hostile_headers_do_not_fill_memory() -> None:
    decoder = FrameDecoder()
    for topic_id in range(5000):
        decoder.feed(frame(topic_id, b""), 0.0)
    assert len(decoder._scanner._known) <= 1024
