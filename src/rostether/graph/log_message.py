"""rosgraph_msgs/Log, written by hand: a node can log before the modules for types have been loaded."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import NamedTuple

from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.rostime import Time

ROSOUT = "/rosout"

# Log lines are read by users; a longer one is data, and would fill the memory of viewers.
MAX_LOG_TEXT_BYTES = 32 << 10

_SEPARATOR = "=" * 80

LOG_TYPE = MessageType(
    "rosgraph_msgs/Log",
    "acffd30cd6b6de30f120938c17c593fb",
    f"""byte DEBUG=1
byte INFO=2
byte WARN=4
byte ERROR=8
byte FATAL=16
Header header
byte level
string name
string msg
string file
string function
uint32 line
string[] topics

{_SEPARATOR}
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
""",
)


class LogRecord(NamedTuple):
    """One log message of a node."""

    node_name: str
    level: Level
    text: str


_HEADER = struct.Struct("<IIIIb")
_UINT32 = struct.Struct("<I")


def encode_log(
    *, sequence: int, stamp: Time, level: Level, node_name: str, text: str, topics: Iterable[str] = ()
) -> bytes:
    """Return the serialized message, without file and line; its text is cut to MAX_LOG_TEXT_BYTES."""
    encoded_topics = [_string(topic) for topic in topics]
    return b"".join(
        (
            _HEADER.pack(sequence & 0xFFFFFFFF, stamp.secs, stamp.nsecs, 0, level),
            _string(node_name),
            _string(text, MAX_LOG_TEXT_BYTES),
            _string(""),
            _string(""),
            _UINT32.pack(0),
            _UINT32.pack(len(encoded_topics)),
            *encoded_topics,
        )
    )


def _string(text: str, max_bytes: int | None = None) -> bytes:
    encoded = text.encode("utf-8", "replace")[:max_bytes]
    return _UINT32.pack(len(encoded)) + encoded
