"""The framed command: a datagram that a robot can check before it moves.

Numbers are little-endian, as on the boards:

    bytes   field
    0-1     magic "rC"
    2       version, 1
    3       flags: 1 armed, 2 stop, 4 release, 8 the target is a mask of groups, 16 query, 32 forward
    4-7     target: a robot's id, or a mask of groups (bit 0 is group 0)
    8-15    epoch: when the sender started, in microseconds since 1970
    16-19   sequence number: 1 for the sender's first frame of the epoch
    20-21   time to live in milliseconds, counted from receipt
    22-23   length of the payload in bytes
    24-27   kind: the first four bytes of the MD5 sum of the payload's type
    28-     payload: one message, in ROS 1 serialization
    last 8  SipHash-2-4 of all bytes before it, under the fleet's key

A fleet without a key uses a key of zeros: the tag then detects damage, but not forgery.
"""

from __future__ import annotations

import hmac
import ipaddress
import struct
from enum import IntFlag

import msgspec

from rostether.errors import RemoteProtocolError
from rostether.mechanisms.text import counted
from rostether.platform.siphash import KEY_BYTES, TAG_BYTES, siphash_2_4

NO_KEY = bytes(KEY_BYTES)
ALL_GROUPS = 0xFFFF_FFFF

# A robot stops when six repetitions of a command in a row are lost.
DEFAULT_TTL_MS = 300

# The longest time that a robot keeps moving after it loses its sender: a fast robot drives a few meters.
MAX_TTL_MS = 1000

# With the header and the tag, it fits in an Ethernet frame: losing one fragment loses the whole datagram.
MAX_PAYLOAD_BYTES = 1400

_HEADER = struct.Struct("<2sBBIQIHH4s")
_MAGIC = b"rC"
_VERSION = 1
HEADER_BYTES = _HEADER.size
# The address and the port of the other robot, in the payload of a frame with the flag FORWARD.
_FORWARD_TARGET = struct.Struct("!16sH")


def type_kind(md5sum: str) -> bytes:
    """Return the kind in frames with messages of a type, given the type's MD5 sum in hexadecimal digits."""
    return bytes.fromhex(md5sum[:8])


class Flags(IntFlag):
    """The request of a frame. QUERY requests the robot's status and changes nothing.

    With FORWARD, a query also asks the robot to send the query in its payload to another robot
    (`encode_forward`). A frame with none of ARMED, STOP, RELEASE and QUERY stops the robot; the sender keeps
    control.
    """

    ARMED = 1
    STOP = 2
    RELEASE = 4
    TO_GROUPS = 8
    QUERY = 16
    FORWARD = 32


class CommandFrame(msgspec.Struct, frozen=True):
    """One framed command; the fields are those of the module's table."""

    target: int
    epoch_us: int
    sequence: int
    flags: Flags = Flags.ARMED
    ttl_ms: int = DEFAULT_TTL_MS
    kind: bytes = bytes(4)
    payload: bytes = b""

    def encode(self, key: bytes = NO_KEY) -> bytes:
        """Return the datagram. The caller has checked the limits."""
        head = _HEADER.pack(
            _MAGIC,
            _VERSION,
            self.flags,
            self.target,
            self.epoch_us,
            self.sequence,
            self.ttl_ms,
            len(self.payload),
            self.kind,
        )
        return head + self.payload + siphash_2_4(key, head + self.payload)


def decode_frame(datagram: bytes, key: bytes) -> CommandFrame:
    """Return the frame in a datagram. Raises RemoteProtocolError with the reason."""
    size = len(datagram)
    if size < HEADER_BYTES + TAG_BYTES or size > HEADER_BYTES + MAX_PAYLOAD_BYTES + TAG_BYTES:
        raise RemoteProtocolError(f"a datagram of {counted(size, 'byte')} is not a framed command")
    magic, version, flags, target, epoch_us, sequence, ttl_ms, length, kind = _HEADER.unpack_from(datagram)
    if magic != _MAGIC:
        raise RemoteProtocolError("the datagram is not a framed command")
    if version != _VERSION:
        raise RemoteProtocolError(
            f"the command has version {version}, not {_VERSION}; update rostether on both sides"
        )
    if length != size - HEADER_BYTES - TAG_BYTES:
        raise RemoteProtocolError(
            f"the command's length field is {length}, but its payload has a different length"
        )
    if not hmac.compare_digest(siphash_2_4(key, datagram[:-TAG_BYTES]), datagram[-TAG_BYTES:]):
        raise RemoteProtocolError(
            "the command's tag is wrong: the frame is damaged, or the sender has a different key; compare "
            "the key files"
        )
    if not 0 < ttl_ms <= MAX_TTL_MS:
        raise RemoteProtocolError(f"a time to live of {ttl_ms} ms is not from 1 to {MAX_TTL_MS}")
    return CommandFrame(
        target, epoch_us, sequence, Flags(flags), ttl_ms, kind, datagram[HEADER_BYTES:-TAG_BYTES]
    )


def encode_forward(address: str, port: int, query: bytes) -> bytes:
    """Return the payload of a frame with the flag FORWARD. Raises ValueError for a host name.

    A forwarded query shows whether two robots reach each other, which an access point may prevent.

        bytes   field
        0-15    address of the other robot: IPv6, or IPv4 as an IPv6 address (::ffff:a.b.c.d)
        16-17   its port, big-endian
        18-     the query, a framed command under the same key
    """
    parsed = ipaddress.ip_address(address)
    mapped = parsed if parsed.version == 6 else ipaddress.IPv6Address(f"::ffff:{parsed}")
    return _FORWARD_TARGET.pack(mapped.packed, port) + query


def decode_forward(payload: bytes, key: bytes) -> tuple[str, int, bytes]:
    """Return address, port and query. Raises RemoteProtocolError for anything that is not a query."""
    if len(payload) < _FORWARD_TARGET.size:
        raise RemoteProtocolError(f"{counted(len(payload), 'byte')} cannot be an address and a query")
    packed, port = _FORWARD_TARGET.unpack_from(payload)
    query = payload[_FORWARD_TARGET.size :]
    # A robot sends nothing else for others: no command, and no bytes of their choice.
    if decode_frame(query, key).flags & ~Flags.TO_GROUPS != Flags.QUERY:
        raise RemoteProtocolError("only queries are forwarded")
    parsed = ipaddress.IPv6Address(packed)
    return str(parsed.ipv4_mapped or parsed), port, query
