"""The status that a robot sends to its sender by unicast.

Numbers are little-endian:

    bytes   field
    0-1     magic "rS"
    2       version, 1
    3       flags: 1 the robot moves; 2 a sender commands it (only from boards)
    4-7     the robot's id
    8-15    epoch of the sender that this answers
    16-19   the last sequence number received from that sender
    20-23   frames received from that sender, without repetitions
    24-27   frames of that sender that were lost or arrived too late
    28      refusal: 0 none, 1 another sender commands, 2 the sender is older, 3 a different type
    29      signal strength in dBm, signed; 0 is unknown
    30-31   length of the next field in bytes
    32-     address of the sender that commands the robot, as text; empty if there is none.
            From a board 6 bytes: IPv4 address and port
    next 8  the robot's clock, in microseconds since 1970 (not from boards)
    next 8  the free space of its disk in bytes (not from boards)
    next 8  epoch of the last sender that the robot obeyed, 0 before the first
    last 8  SipHash-2-4 of all bytes before it, under the fleet's key
"""

from __future__ import annotations

import hmac
import struct
from enum import IntEnum
from ipaddress import IPv4Address

import msgspec

from rostether.errors import RemoteProtocolError
from rostether.mechanisms.text import counted
from rostether.platform.command_frame import NO_KEY
from rostether.platform.siphash import TAG_BYTES, siphash_2_4

# The length of an IPv6 address with the name of its interface, and a port.
_MAX_HOLDER_BYTES = 80

_HEADER = struct.Struct("<2sBBIQIIIBbH")
_HOST = struct.Struct("<QQ")
_EPOCH = struct.Struct("<Q")
MAGIC = b"rS"
_MIN_BYTES = _HEADER.size + TAG_BYTES
_VERSION = 1
_MOVES = 1
_IS_HELD = 2
# In network order. An address as text is always longer than 6 bytes.
_BOARDS_HOLDER = struct.Struct("<4sH")
_LAST_U32 = 0xFFFF_FFFF


class Refusal(IntEnum):
    """Why a robot does not obey a sender."""

    NONE = 0
    HELD = 1
    OLDER = 2
    OTHER_TYPE = 3


class HostState(msgspec.Struct, frozen=True):
    """The clock of a robot's computer, and the free space of its disk."""

    clock_us: int
    free_bytes: int


class RobotStatus(msgspec.Struct, frozen=True):
    """One status; the fields are those of the module's table.

    `signal_dbm` is None if it is unknown, `host` if the robot is a board.
    """

    robot_id: int
    epoch_us: int
    sequence: int
    received_count: int = 0
    lost_count: int = 0
    is_moving: bool = False
    refusal: Refusal = Refusal.NONE
    signal_dbm: int | None = None
    holder: str = ""
    host: HostState | None = None
    last_epoch_us: int = 0

    def encode(self, key: bytes = NO_KEY) -> bytes:
        """Return the datagram; counts restart from 0 after 2^32."""
        holder = self.holder.encode("ascii", "replace")[:_MAX_HOLDER_BYTES]
        body = (
            _HEADER.pack(
                MAGIC,
                _VERSION,
                _MOVES if self.is_moving else 0,
                self.robot_id,
                self.epoch_us,
                self.sequence,
                self.received_count & _LAST_U32,
                self.lost_count & _LAST_U32,
                self.refusal,
                max(-128, min(self.signal_dbm or 0, 127)),
                len(holder),
            )
            + holder
        )
        if self.host is not None:
            body += _HOST.pack(self.host.clock_us, self.host.free_bytes)
        body += _EPOCH.pack(self.last_epoch_us)
        return body + siphash_2_4(key, body)


def decode_status(datagram: bytes, key: bytes) -> RobotStatus:
    """Return the status in a datagram. Raises RemoteProtocolError with the reason."""
    if not _MIN_BYTES <= len(datagram) <= _MIN_BYTES + _MAX_HOLDER_BYTES + _HOST.size + _EPOCH.size:
        raise RemoteProtocolError(f"a datagram of {counted(len(datagram), 'byte')} is not a status")
    header = _HEADER.unpack_from(datagram)
    magic, version, state, robot_id, epoch_us, sequence, received, lost, refusal, signal, length = header
    if magic != MAGIC or version != _VERSION:
        raise RemoteProtocolError("the datagram is not a status of version 1")
    body, tag = datagram[:-TAG_BYTES], datagram[-TAG_BYTES:]
    holder, rest = body[_HEADER.size :][:length], body[_HEADER.size + length :]
    # Boards have no disk, and those with an earlier library send no epoch.
    if len(holder) != length or len(rest) not in (0, _EPOCH.size, _HOST.size + _EPOCH.size):
        raise RemoteProtocolError(
            f"the status's length field is {length}, but the text has a different length"
        )
    if not hmac.compare_digest(siphash_2_4(key, body), tag):
        raise RemoteProtocolError(
            "the status's tag is wrong: the frame is damaged, or the robot has a different key"
        )
    if refusal not in list(Refusal):
        raise RemoteProtocolError(f"the status has an unknown refusal code, {refusal}")
    return RobotStatus(
        robot_id,
        epoch_us,
        sequence,
        received,
        lost,
        bool(state & _MOVES),
        Refusal(refusal),
        signal or None,
        _decode_holder(holder, state),
        HostState(*_HOST.unpack_from(rest)) if len(rest) > _EPOCH.size else None,
        _EPOCH.unpack(rest[-_EPOCH.size :])[0] if rest else 0,
    )


def _decode_holder(address: bytes, state: int) -> str:
    if len(address) != _BOARDS_HOLDER.size:
        return address.decode("ascii", "replace")
    if not state & _IS_HELD:
        return ""
    ip, port = _BOARDS_HOLDER.unpack(address)
    return f"{IPv4Address(ip)}:{port}"
