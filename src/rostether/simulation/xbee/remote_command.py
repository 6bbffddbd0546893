"""AT commands for other radios: the frames 0x17 and 0x97 of the API, and the packets between radios.

    0x17  frame id, 64-bit address, 16-bit address, options, command, value
    0x97  frame id, 64-bit address, 16-bit address, command, status, value

Source: Digi, XBee 802.15.4 and DigiMesh User Guides, "Remote AT Command Request", "Remote Command Response".
"""

from __future__ import annotations

from typing import NamedTuple

# The shortest frame of type 0x17.
REQUEST_BYTES = 15
# The status of a response if the request was not acknowledged.
NOT_SENT = 4

# With these values in the 64-bit field, the address is in the 16-bit field.
_USES_SHORT = (0xFFFFFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFE)
_NO_SHORT = b"\xff\xfe"
_APPLY = 0x02


class RemoteCommand(NamedTuple):
    """An AT command for another radio."""

    frame_id: int
    destination: int
    is_long: bool
    is_applied: bool
    command: str
    value: bytes


class RemoteAnswer(NamedTuple):
    """The answer of the other radio."""

    frame_id: int
    command: str
    status: int
    value: bytes = b""


def parse_request(frame: bytes) -> RemoteCommand:
    """Return the command of a frame of type 0x17, which has at least `REQUEST_BYTES`."""
    long, short = int.from_bytes(frame[2:10], "big"), int.from_bytes(frame[10:12], "big")
    is_long = long not in _USES_SHORT
    command = frame[13:15].decode("latin-1")
    return RemoteCommand(
        frame[1], long if is_long else short, is_long, bool(frame[12] & _APPLY), command, frame[15:]
    )


def build_response(answer: RemoteAnswer, long_source: int, short_source: int | None) -> bytes:
    """Return a frame of type 0x97."""
    short = _NO_SHORT if short_source is None else short_source.to_bytes(2, "big")
    return b"".join(
        (
            bytes((0x97, answer.frame_id)),
            long_source.to_bytes(8, "big"),
            short,
            answer.command.encode("latin-1"),
            bytes((answer.status,)),
            answer.value,
        )
    )
