from __future__ import annotations

import pytest

from rostether.errors import RemoteProtocolError
from rostether.platform.command_frame import MAX_PAYLOAD_BYTES, NO_KEY, CommandFrame, Flags, decode_frame

KEY = b"0123456789abcdef"
FRAME = CommandFrame(
    7, 0x0102030405060708, 9, Flags.ARMED | Flags.STOP, 300, b"\x75\x28\xcb\x4c", bytes(range(16))
)


def test_the_bytes_of_a_frame() -> None:
    encoded = FRAME.encode(KEY)
    assert encoded[:-8].hex(" ", 4) == (
        "72430103 07000000 08070605 04030201 09000000 2c011000 7528cb4c 00010203 04050607 08090a0b 0c0d0e0f"
    )
    assert decode_frame(encoded, KEY) == FRAME


def test_every_damaged_bit_is_refused() -> None:
    encoded = FRAME.encode(KEY)
    for bit in range(len(encoded) * 8):
        damaged = bytearray(encoded)
        damaged[bit // 8] ^= 1 << bit % 8
        with pytest.raises(RemoteProtocolError):
            decode_frame(bytes(damaged), KEY)


@pytest.mark.parametrize("size", range(60))
def test_every_cut_is_refused(size: int) -> None:
    encoded = FRAME.encode(KEY)
    if size != len(encoded):
        with pytest.raises(RemoteProtocolError):
            decode_frame(encoded[:size] if size < len(encoded) else encoded + bytes(size), KEY)


def test_another_key_is_refused() -> None:
    with pytest.raises(RemoteProtocolError, match="a different key"):
        decode_frame(FRAME.encode(KEY), NO_KEY)


@pytest.mark.parametrize("ttl_ms", [0, 1001, 65535])
def test_a_time_to_live_out_of_bounds(ttl_ms: int) -> None:
    with pytest.raises(RemoteProtocolError, match=f"a time to live of {ttl_ms} ms is not from 1 to 1000"):
        decode_frame(CommandFrame(1, 1, 1, ttl_ms=ttl_ms).encode(), NO_KEY)


def test_other_datagrams() -> None:
    for datagram in (b"", bytes(16), bytes(60), bytes(65507), b"rC" + bytes(58)):
        with pytest.raises(RemoteProtocolError):
            decode_frame(datagram, NO_KEY)
    longest = CommandFrame(1, 1, 1, payload=bytes(MAX_PAYLOAD_BYTES)).encode()
    assert decode_frame(longest, NO_KEY).sequence == 1
