"""Properties of every stream: chunks change nothing, garbage raises no error, frames after it are found."""

from __future__ import annotations

import itertools

from hypothesis import assume, given
from hypothesis import strategies as st

from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame import FORMS, encode_frame, encode_frames
from rostether.rosserial.frame_decoder import MAX_SEARCH_S, Decoded, FrameDecoder, PayloadLimits
from unit.rosserial.decoding import by_topic, frame

versions = st.sampled_from(tuple(FORMS))
topic_ids = st.one_of(st.integers(0, 12), st.integers(100, 130), st.integers(0, 0xFFFF))
payloads = st.one_of(st.binary(max_size=40), st.binary(min_size=250, max_size=520))
frame_bytes = st.sampled_from([0xFF, 0xFE, 0x00, 0x01, 0x7D])
false_headers = st.builds(lambda size: frame(125, bytes(size))[:7], st.integers(0, 0xFFFF))
noise = st.one_of(
    st.binary(max_size=30),
    st.lists(frame_bytes, max_size=30).map(bytes),
    st.lists(false_headers, max_size=5).map(b"".join),
)


@st.composite
def streams(draw: st.DrawFn) -> tuple[int, bytes]:
    """Draw a protocol version, and a stream of its frames with noise and damage."""
    version = draw(versions)
    pieces = []
    for _ in range(draw(st.integers(0, 12))):
        one = frame(draw(topic_ids), draw(payloads), version)
        kind = draw(st.integers(0, 5))
        if kind == 0:
            pieces.append(draw(noise))
        elif kind == 1:
            position = draw(st.integers(0, len(one) - 1))
            one = one[:position] + draw(noise) + one[position + draw(st.integers(0, 3)) :]
        pieces.append(one)
    return version, b"".join(pieces)


def split(data: bytes, cuts: list[int]) -> list[bytes]:
    """Split bytes at positions, which may exceed their length."""
    positions = sorted({cut % (len(data) + 1) for cut in cuts} | {0, len(data)})
    return [data[start:end] for start, end in itertools.pairwise(positions)]


def finish(decoder: FrameDecoder, decoded: list[Decoded]) -> list[Decoded]:
    return decoded + decoder.abandon(0.0)


def total_bytes(decoded: list[Decoded], version: int) -> int:
    overhead = 8 if version == 2 else 7
    return sum(
        len(item.data)
        if isinstance(item, FrameDiscarded)
        else sum(len(payload) + overhead for payload in item.payloads)
        for item in decoded
    )


@given(streams(), st.lists(st.integers(0, 10_000), max_size=40))
def test_any_chunking_gives_the_same_frames(stream: tuple[int, bytes], cuts: list[int]) -> None:
    version, data = stream
    whole, chunked = FrameDecoder(version), FrameDecoder(version)
    expected = by_topic(whole.feed(data, 0.0))
    found: list[Decoded] = []
    for chunk in split(data, cuts):
        found += chunked.feed(chunk, 0.0)
    assert by_topic(found) == expected
    assert chunked.pending_bytes == whole.pending_bytes


@given(streams(), st.lists(st.integers(0, 10_000), max_size=40))
def test_every_byte_is_delivered_or_discarded_exactly_once(
    stream: tuple[int, bytes], cuts: list[int]
) -> None:
    version, data = stream
    decoder = FrameDecoder(version)
    decoded: list[Decoded] = []
    for chunk in split(data, cuts):
        decoded += decoder.feed(chunk, 0.0)
    assert total_bytes(finish(decoder, decoded), version) == len(data)


@given(versions, st.binary(max_size=400), st.lists(st.floats(0, 0.3), min_size=1, max_size=20))
def test_garbage_never_raises(version: int, garbage: bytes, pauses: list[float]) -> None:
    decoder = FrameDecoder(version)
    now_s = 0.0
    decoded: list[Decoded] = []
    step = len(garbage) // len(pauses) + 1
    for number, pause_s in enumerate(pauses):
        now_s += pause_s
        decoded += decoder.handle_timer(now_s)
        decoded += decoder.feed(garbage[number * step : (number + 1) * step], now_s)
    assert total_bytes(finish(decoder, decoded), version) == len(garbage)


@given(noise, st.binary(max_size=60))
def test_a_frame_after_garbage_is_found_when_the_line_pauses(garbage: bytes, payload: bytes) -> None:
    # After any bytes, a frame on an announced id is delivered within MAX_SEARCH_S after its
    # last byte, at the next check, even if nothing follows it. Earlier bytes may also complete a valid
    # frame with the beginning of this one; such inputs are not checked.
    valid = frame(125, payload)
    decoder = FrameDecoder(limits=PayloadLimits({125: 100}))
    decoded = decoder.feed(garbage + valid, 0.0)
    last_check_s = 0.0
    while (due_s := decoder.get_timer()) is not None:
        last_check_s = due_s
        decoded += decoder.handle_timer(due_s)
    found = by_topic(decoded)
    accidental = [
        piece for topic_id, pieces in found.items() for piece in pieces if (topic_id, piece) != (125, payload)
    ]
    assume(not accidental)
    assert found[125][-1] == payload
    assert last_check_s <= MAX_SEARCH_S


@given(noise, st.lists(st.binary(max_size=60), min_size=1, max_size=5))
def test_frames_after_garbage_are_found_while_the_line_flows(garbage: bytes, sent: list[bytes]) -> None:
    # A false header claims at most 65,535 bytes; after that, all frames behind it have been found.
    decoder = FrameDecoder()
    wanted = b"".join(frame(125, payload) for payload in sent)
    filler = frame(126, bytes(1000)) * 67
    data = garbage + wanted + filler
    found = by_topic(decoder.feed(data, 0.0))
    assume(set(found) == {125, 126})

    def begins_in_garbage(topic_id: int, payload: bytes) -> bool:
        encoded = frame(topic_id, payload)
        start = data.find(encoded)
        return start < len(garbage) < start + len(encoded)

    # As above: a false header may complete a valid frame with the bytes after it.
    assume(
        not any(
            begins_in_garbage(topic_id, each) for topic_id, pieces in found.items() for each in set(pieces)
        )
    )
    assert found[125][-len(sent) :] == sent


@given(versions, topic_ids, st.lists(payloads, max_size=10))
def test_round_trip(version: int, topic_id: int, sent: list[bytes]) -> None:
    data = encode_frames(topic_id, sent, version)
    assert data == b"".join(encode_frame(topic_id, payload, version) for payload in sent)
    decoded = FrameDecoder(version).feed(data, 0.0)
    assert by_topic(decoded) == ({topic_id: sent} if sent else {})
