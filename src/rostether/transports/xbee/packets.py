"""The frames that an XBee radio and its host exchange, sans I/O.

    host to radio
    00 | frame id | destination u64 BE | options | payload                     802.15.4, 64-bit address
    01 | frame id | destination u16 BE | options | payload                     802.15.4, 16-bit address
    10 | frame id | destination u64 BE | FF FE | radius | options | payload    DigiMesh
    08 | frame id | two letters | value                                        AT command

    radio to host
    80 | source u64 BE | signal | options | payload     received; signal strength in -dBm
    81 | source u16 BE | signal | options | payload
    90 | source u64 BE | FF FE | options | payload
    88 | frame id | two letters | status | value        answer to an AT command
    89 | frame id | status                              whether a packet was delivered
    8B | frame id | FF FE | retries | status | discovery      the same, in DigiMesh

A packet with frame id 0 gets no status.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from rostether.transports.xbee.frame import encode_frame
from rostether.transports.xbee.radio_address import is_long

# The radio's limit of one packet, for series 1. Others report theirs by NP.
MAX_PAYLOAD_BYTES = 100
MESH_PAYLOAD_BYTES = 73

_TX_64, _TX_16, _AT, _TX_MESH = 0x00, 0x01, 0x08, 0x10

_DELIVERED = 0
_STATUS_TEXTS = {
    0x00: "delivered",
    0x01: "no acknowledgement",
    0x02: "the channel is busy",
    0x03: "dropped by the radio",
    0x15: "invalid destination",
    0x21: "no acknowledgement",
    0x22: "the radio is not in a network",
    0x24: "no such address",
    0x25: "no route",
    0x31: "the radio is out of memory",
    0x32: "the radio is out of memory",
    0x74: "the packet is too long",
}


class RadioPacket(NamedTuple):
    """One packet received over the air; `rssi_dbm` is None if its frame has no signal strength."""

    source: int
    payload: bytes
    rssi_dbm: int | None
    is_mesh: bool = False


class TransmitStatus(NamedTuple):
    """The result of the packet with a frame id; `retries` is None if the radio does not count them."""

    frame_id: int
    status: int
    retries: int | None

    @property
    def is_delivered(self) -> bool:
        """Whether the other radio acknowledged it."""
        return self.status == _DELIVERED


class AtAnswer(NamedTuple):
    """An answer to an AT command; `is_ok` is False for an unknown command or a wrong value."""

    frame_id: int
    command: str
    is_ok: bool
    value: bytes


RadioReport: TypeAlias = RadioPacket | TransmitStatus | AtAnswer


def status_text(status: int) -> str:
    """Return a transmit status in words."""
    return _STATUS_TEXTS.get(status, f"status {status:#04x}")


def encode_packet(
    destination: int, payload: bytes, *, frame_id: int, is_mesh: bool = False, limit_bytes: int
) -> bytes:
    """Return the frame that sends a packet of at most `limit_bytes` to an address. Raises ValueError."""
    if len(payload) > limit_bytes:
        raise ValueError(f"a radio packet can hold {limit_bytes} bytes, not {len(payload)}")
    if is_mesh:
        header = bytes((_TX_MESH, frame_id, *destination.to_bytes(8, "big"), 0xFF, 0xFE, 0, 0))
    elif not is_long(destination):
        header = bytes((_TX_16, frame_id, *destination.to_bytes(2, "big"), 0))
    else:
        header = bytes((_TX_64, frame_id, *destination.to_bytes(8, "big"), 0))
    return encode_frame(header + payload)


def encode_at(command: str, value: bytes = b"", *, frame_id: int) -> bytes:
    """Return the frame that reads a register of the radio, or sets it."""
    return encode_frame(bytes((_AT, frame_id)) + command.encode("ascii") + value)


def parse_report(data: bytes) -> RadioReport | None:
    """Return the content of a frame from the radio; None for other kinds and for short frames."""
    kind = data[0] if data else None
    match kind:
        case 0x80 if len(data) >= 11:
            return RadioPacket(int.from_bytes(data[1:9], "big"), data[11:], -data[9])
        case 0x81 if len(data) >= 5:
            return RadioPacket(int.from_bytes(data[1:3], "big"), data[5:], -data[3])
        case 0x90 if len(data) >= 12:
            return RadioPacket(int.from_bytes(data[1:9], "big"), data[12:], None, is_mesh=True)
        case 0x88 if len(data) >= 5:
            return AtAnswer(data[1], data[2:4].decode("latin-1"), data[4] == 0, data[5:])
        case 0x89 if len(data) >= 3:
            return TransmitStatus(data[1], data[2], None)
        case 0x8B if len(data) >= 6:
            return TransmitStatus(data[1], data[5], data[4])
        case _:
            return None
