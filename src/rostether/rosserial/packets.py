"""The control packets of rosserial, encoded and decoded by hand; decoding is strict.

    TopicInfo              uint16 topic_id, string topic_name, string message_type, string md5sum, int32 buffer_size
    Log                    uint8 level, string msg
    RequestParam request   string name
    RequestParam response  int32[] ints, float32[] floats, string[] strings
    Time                   uint32 secs, uint32 nsecs

About one damaged frame in 256 passes its checksum, so a payload is believed only if it has exactly its layout
and says something possible. Source: rosserial_msgs, std_msgs/Time.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from rostether.errors import RemoteProtocolError
from rostether.rosserial.topic_id import FIRST_USER_ID
from rostether.rostime import NS_PER_S, Time

MAX_NAME_BYTES = 255
"""Names and types longer than this do not fit the buffers of any board; one that claims more is damage."""

MAX_BUFFER_BYTES = 1 << 24
"""The length field of a frame ends at 65535; some Linux devices announce more, but none 16 MiB."""

_NAME = re.compile(r"[~/]?[A-Za-z][A-Za-z0-9_]*(?:/[A-Za-z][A-Za-z0-9_]*)*\Z")
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*/[A-Za-z][A-Za-z0-9_]*\Z")
_MD5SUM = re.compile(r"[0-9a-f]{32}\Z")

_LENGTH = struct.Struct("<I")
_TIME = struct.Struct("<II")
_TOPIC_ID = struct.Struct("<H")
_BUFFER_SIZE = struct.Struct("<i")


class LogLevel(IntEnum):
    """Severities of rosserial_msgs/Log."""

    DEBUG = 0
    INFO = 1
    WARN = 2
    ERROR = 3
    FATAL = 4


@dataclass(frozen=True, slots=True)
class TopicInfo:
    """One announced endpoint. `buffer_size` in bytes: what the device can send (with 8 of framing) or receive."""

    topic_id: int
    topic_name: str
    message_type: str
    md5sum: str
    buffer_size: int


class ParameterResponse(NamedTuple):
    """The answer to a parameter request; all three empty when the parameter does not exist."""

    ints: tuple[int, ...] = ()
    floats: tuple[float, ...] = ()
    strings: tuple[str, ...] = ()
