"""The byte strings are worked out by hand from the layout in Digi's manual; the TX one is its own example."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.transports.xbee_frame import (
    MAX_PAYLOAD_BYTES,
    RadioPacket,
    XbeeFrameDecoder,
    encode_frame,
    encode_tx,
)

# Source 0x7E7D and payload 11 13 with every byte that needs it escaped.
RX_ESCAPED = bytes.fromhex("7E 00 07 81 7D5E 7D5D 28 00 7D31 7D33 37".replace(" ", ""))


def rx_frame(source: int, payload: bytes) -> bytes:
    return encode_frame(bytes((0x81, *source.to_bytes(2, "big"), 0x28, 0)) + payload)


def test_encode_the_manuals_example() -> None:
    assert encode_tx(0x5001, b"Hello", frame_id=1) == bytes.fromhex("7E000A010150010048656C6C6FB8")


def test_encode_asks_for_no_status_unless_told() -> None:
    assert encode_tx(0x5001, b"Hello") == bytes.fromhex("7E000A010050010048656C6C6FB9")


def test_encode_escapes_everything_after_the_delimiter() -> None:
    assert encode_frame(bytes.fromhex("817E7D28001113")) == RX_ESCAPED


def test_encode_escapes_length_and_checksum() -> None:
    frame = encode_frame(bytes(0x11 - 1) + b"\x81")
    assert frame[:4] == bytes.fromhex("7E007D31")
    assert frame[-2:] == bytes.fromhex("7D5E")


def test_encode_refuses_what_no_packet_holds() -> None:
    encode_tx(1, bytes(MAX_PAYLOAD_BYTES))
    with pytest.raises(ValueError, match="100 bytes, not 101"):
        encode_tx(1, bytes(MAX_PAYLOAD_BYTES + 1))


@pytest.mark.parametrize(
    ("frame", "packet"),
    [
        (bytes.fromhex("7E000A815001280048656C6C6F7D31"), RadioPacket(0x5001, b"Hello")),
        (RX_ESCAPED, RadioPacket(0x7E7D, b"\x11\x13")),
    ],
)
def test_decode_by_hand(frame: bytes, packet: RadioPacket) -> None:
    assert XbeeFrameDecoder().feed(frame) == [packet]


def test_pass_over_other_kinds_of_frames() -> None:
    tx_status = encode_frame(bytes((0x89, 1, 0)))
    decoder = XbeeFrameDecoder()
    assert decoder.feed(tx_status + rx_frame(1, b"x")) == [RadioPacket(1, b"x")]


def test_damage_costs_one_frame() -> None:
    good = rx_frame(1, b"good")
    bad = bytearray(rx_frame(1, b"bad!"))
    bad[-2] ^= 1
    decoder = XbeeFrameDecoder()
    assert decoder.feed(bytes(bad) + good) == [RadioPacket(1, b"good")]


def test_a_cut_frame_costs_only_itself() -> None:
    good = rx_frame(1, b"good")
    decoder = XbeeFrameDecoder()
    assert decoder.feed(good[:7] + good) == [RadioPacket(1, b"good")]


def test_a_damaged_length_is_not_waited_for() -> None:
    decoder = XbeeFrameDecoder()
    assert decoder.feed(bytes.fromhex("7E7000") + bytes(300)) == []
    assert decoder.feed(rx_frame(1, b"x")) == [RadioPacket(1, b"x")]


@given(
    packets=st.lists(st.tuples(st.integers(0, 0xFFFD), st.binary(max_size=MAX_PAYLOAD_BYTES)), max_size=8),
    cuts=st.lists(st.integers(1, 40), min_size=1, max_size=30),
)
def test_any_cutting_gives_the_same_packets(packets: list[tuple[int, bytes]], cuts: list[int]) -> None:
    stream = b"".join(rx_frame(source, payload) for source, payload in packets)
    decoder = XbeeFrameDecoder()
    found, position, turn = [], 0, 0
    while position < len(stream):
        size = cuts[turn % len(cuts)]
        found += decoder.feed(stream[position : position + size])
        position += size
        turn += 1
    assert found == [RadioPacket(*packet) for packet in packets]


@given(st.binary(max_size=400))
def test_garbage_never_raises_and_the_next_frame_is_found(garbage: bytes) -> None:
    decoder = XbeeFrameDecoder()
    decoder.feed(garbage)
    assert RadioPacket(7, b"after") in decoder.feed(rx_frame(7, b"after"))
