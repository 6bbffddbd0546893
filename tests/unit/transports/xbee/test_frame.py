"""The byte strings are worked out by hand from the layout in Digi's manual; the TX one is its own example."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.transports.xbee.frame import XbeeFrameDecoder, encode_frame

# Source 0x7E7D and payload 11 13 with every byte that needs it escaped.
RX_ESCAPED = bytes.fromhex("7E 00 07 81 7D5E 7D5D 28 00 7D31 7D33 37".replace(" ", ""))
RX = bytes.fromhex("817E7D28001113")


def rx_frame(source: int, payload: bytes) -> bytes:
    return encode_frame(bytes((0x81, *source.to_bytes(2, "big"), 0x28, 0)) + payload)


def test_encode_escapes_everything_after_the_delimiter() -> None:
    assert encode_frame(RX) == RX_ESCAPED
    assert encode_frame(RX, escaped=False) == bytes.fromhex("7E0007") + RX + RX_ESCAPED[-1:]


def test_encode_escapes_length_and_checksum() -> None:
    frame = encode_frame(bytes(0x11 - 1) + b"\x81")
    assert frame[:4] == bytes.fromhex("7E007D31")
    assert frame[-2:] == bytes.fromhex("7D5E")


@pytest.mark.parametrize("escaped", [True, False])
def test_decode_both_modes(escaped: bool) -> None:
    decoder = XbeeFrameDecoder(escaped=escaped)
    assert decoder.feed(encode_frame(RX, escaped=escaped) * 2) == [RX, RX]


def test_damage_costs_one_frame() -> None:
    bad = bytearray(encode_frame(b"bad!"))
    bad[-2] ^= 1
    assert XbeeFrameDecoder().feed(bytes(bad) + encode_frame(b"good")) == [b"good"]


def test_a_cut_frame_damages_no_other_frame() -> None:
    good = encode_frame(b"good")
    assert XbeeFrameDecoder().feed(good[:5] + good) == [b"good"]


def test_a_damaged_length_is_not_waited_for() -> None:
    decoder = XbeeFrameDecoder()
    assert decoder.feed(bytes.fromhex("7E7000") + bytes(300)) == []
    assert decoder.feed(encode_frame(b"x")) == [b"x"]


@given(
    frames=st.lists(st.binary(min_size=1, max_size=116), max_size=8),
    cuts=st.lists(st.integers(1, 40), min_size=1, max_size=30),
)
def test_chunks_of_any_size_give_the_same_frames(frames: list[bytes], cuts: list[int]) -> None:
    stream = b"".join(encode_frame(frame) for frame in frames)
    decoder = XbeeFrameDecoder()
    found, position, turn = [], 0, 0
    while position < len(stream):
        size = cuts[turn % len(cuts)]
        found += decoder.feed(stream[position : position + size])
        position += size
        turn += 1
    assert found == frames


@given(st.binary(max_size=400))
def test_garbage_never_raises_and_the_next_frame_is_found(garbage: bytes) -> None:
    decoder = XbeeFrameDecoder()
    decoder.feed(garbage)
    assert b"after" in decoder.feed(encode_frame(b"after"))
