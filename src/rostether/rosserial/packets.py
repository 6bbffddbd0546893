"""The control packets of rosserial, encoded and decoded by hand; decoding is strict.

    TopicInfo              uint16 topic_id, string topic_name, string message_type, string md5sum,
                           int32 buffer_size
    Log                    uint8 level, string msg
    RequestParam request   string name
    RequestParam response  int32[] ints, float32[] floats, string[] strings
    Time                   uint32 secs, uint32 nsecs

About one damaged frame in 256 passes its checksum. A payload is therefore accepted only if it has exactly its
layout and possible values; otherwise the decoders return None. Source: rosserial_msgs, std_msgs/Time.
"""

from __future__ import annotations

import re
import struct
from enum import IntEnum
from typing import Any, NamedTuple

import msgspec

from rostether.errors import LocalProtocolError
from rostether.rosserial.topic_id import FIRST_USER_ID, LAST_ID
from rostether.rostime import NS_PER_S, Time

# Longer names and types fit no board's buffer (150 to 512 bytes), so they are damage.
MAX_NAME_BYTES = 255

# A frame holds at most 65535 bytes. Devices with more memory may round up, but to no more than 1 MiB.
MAX_BUFFER_BYTES = 1 << 20

# The output buffer of a device must also hold these bytes of a frame, in both versions (established library).
PUBLISHER_OVERHEAD_BYTES = 8

TIME_BYTES = 8

# A request needs no content: some firmware sends it empty, and the established host answers it.
TIME_REQUEST_BYTES = (0, TIME_BYTES)

_NAME = re.compile(r"(?!.*//)[A-Za-z~/][A-Za-z0-9_/]*\Z", re.ASCII)
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*/[A-Za-z][A-Za-z0-9_]*\Z", re.ASCII)
_MD5SUM = re.compile(r"[0-9a-f]{32}\Z", re.ASCII)
_COUNT = struct.Struct("<I")
_TIME = struct.Struct("<II")
_ID = struct.Struct("<H")
_BUFFER_SIZE = struct.Struct("<i")


class LogLevel(IntEnum):
    """Severities of rosserial_msgs/Log."""

    DEBUG = 0
    INFO = 1
    WARN = 2
    ERROR = 3
    FATAL = 4


class TopicInfo(msgspec.Struct, frozen=True):
    """One announced endpoint; `buffer_size` is its buffer in bytes, with 8 bytes of framing if it sends."""

    topic_id: int
    topic_name: str
    message_type: str
    md5sum: str
    buffer_size: int

    def encode(self) -> bytes:
        """Return the payload. Raises LocalProtocolError for an id or a size that does not fit."""
        try:
            head, tail = _ID.pack(self.topic_id), _BUFFER_SIZE.pack(self.buffer_size)
        except struct.error:
            raise LocalProtocolError(
                f"cannot announce {self.topic_name}: topic id {self.topic_id} does not fit in uint16, or "
                f"buffer size {self.buffer_size} not in int32; use smaller numbers"
            ) from None
        return head + _string(self.topic_name) + _string(self.message_type) + _string(self.md5sum) + tail

    @classmethod
    def decode(cls, payload: bytes) -> TopicInfo | None:
        """Decode an announcement; None if a name, the type, the md5sum, the id or the size is impossible."""
        info = cls.read(payload)
        return info if info is not None and info.fault() is None else None

    @classmethod
    def read(cls, payload: bytes) -> TopicInfo | None:
        """Decode an announcement without checking its content; None if the payload has another layout."""
        reader = _Reader(payload)
        topic_id = reader.number(_ID)
        name, message_type, md5sum = (reader.text(MAX_NAME_BYTES, errors="replace") for _ in range(3))
        buffer_size = reader.number(_BUFFER_SIZE)
        return cls(topic_id, name, message_type, md5sum, buffer_size) if reader.is_complete else None

    def fault(self) -> str | None:
        """Return the impossible value and the change that the sketch needs, None if all are possible."""
        if not FIRST_USER_ID <= self.topic_id <= LAST_ID:
            return (
                f"its topic id is {self.topic_id}, but ids below {FIRST_USER_ID} are reserved;"
                " use a larger one"
            )
        if not _is_name(self.topic_name):
            return (
                "a name must start with a letter and have only letters, digits, _ and /;"
                f" {_better_name(self)} in the sketch"
            )
        if not _TYPE.match(self.message_type):
            return f"a type must be package/Type; {_better_type(self.message_type)} in the sketch"
        if not _MD5SUM.match(self.md5sum):
            return (
                f"its md5sum {self.md5sum!r} is not 32 digits of 0-9a-f; generate the message headers of the"
                " sketch again"
            )
        if not 0 <= self.buffer_size <= MAX_BUFFER_BYTES:
            return (
                f"its buffer size is {self.buffer_size} bytes; choose 0 to {MAX_BUFFER_BYTES} in the sketch's"
                " NodeHandle_"
            )
        return None


class Log(NamedTuple):
    """One log line of a device."""

    level: LogLevel
    text: str

    def encode(self) -> bytes:
        """Return the payload."""
        return bytes((self.level,)) + _string(self.text)

    @classmethod
    def decode(cls, payload: bytes) -> Log | None:
        """Decode a log line; a level above FATAL becomes FATAL, and invalid UTF-8 is replaced.

        None if the payload has another layout.
        """
        if not payload:
            return None
        reader = _Reader(payload, 1)
        text = reader.text(len(payload), errors="replace")
        return cls(LogLevel(min(payload[0], LogLevel.FATAL)), text) if reader.is_complete else None


class ParameterRequest(NamedTuple):
    """A device asks for a parameter."""

    name: str

    def encode(self) -> bytes:
        """Return the payload."""
        return _string(self.name)

    @classmethod
    def decode(cls, payload: bytes) -> ParameterRequest | None:
        """Decode a request; None if its layout is wrong, or its name is empty or not printable."""
        reader = _Reader(payload)
        name = reader.text(MAX_NAME_BYTES)
        return cls(name) if reader.is_complete and name and name.isprintable() else None


class ParameterResponse(NamedTuple):
    """The answer to a parameter request; all three empty when the parameter does not exist."""

    ints: tuple[int, ...] = ()
    floats: tuple[float, ...] = ()
    strings: tuple[str, ...] = ()

    def encode(self) -> bytes:
        """Return the payload. Raises LocalProtocolError for numbers beyond int32 and float32."""
        try:
            ints = struct.pack(f"<I{len(self.ints)}i", len(self.ints), *self.ints)
            floats = struct.pack(f"<I{len(self.floats)}f", len(self.floats), *self.floats)
        except (struct.error, OverflowError):
            raise LocalProtocolError(
                "a parameter value does not fit in int32 or float32; use smaller numbers"
            ) from None
        return ints + floats + _COUNT.pack(len(self.strings)) + b"".join(map(_string, self.strings))

    @classmethod
    def decode(cls, payload: bytes) -> ParameterResponse | None:
        """Decode an answer; None if the payload has another layout."""
        reader = _Reader(payload)
        ints = reader.array("i")
        floats = reader.array("f")
        count = reader.number(_COUNT)
        if count * _COUNT.size > reader.left_bytes:
            return None
        strings = tuple(reader.text(len(payload)) for _ in range(count))
        return cls(ints, floats, strings) if reader.is_complete else None


def encode_time(time: Time) -> bytes:
    """Return the payload of a time request or answer; seconds wrap as uint32 does."""
    return _TIME.pack(time.secs & 0xFFFFFFFF, time.nsecs)


def decode_time(payload: bytes) -> Time | None:
    """Decode a time; None unless it has 8 bytes and less than a second of nanoseconds."""
    if len(payload) != TIME_BYTES:
        return None
    secs, nsecs = _TIME.unpack(payload)
    return Time(secs, nsecs) if nsecs < NS_PER_S else None


def _is_name(name: str) -> bool:
    return bool(_NAME.match(name)) and len(name.strip("~/")) > 0


def _better_name(info: TopicInfo) -> str:
    better = re.sub(r"/{2,}", "/", re.sub(r"[^A-Za-z0-9_/]", "_", info.topic_name)).lstrip("_0123456789")
    return f"write {better}" if _is_name(better) else "choose another"


def _better_type(message_type: str) -> str:
    words = [word for word in re.findall(r"[A-Za-z]\w*", message_type) if word not in ("msg", "srv")]
    if len(words) == 2:
        return "write " + "/".join(words)
    return "include the package, as in std_msgs/String," if len(words) == 1 else "write one"


def _string(text: str) -> bytes:
    data = text.encode("utf-8", "surrogateescape")
    return _COUNT.pack(len(data)) + data


class _Reader:
    """Reads fields in order; after one that does not fit, all fields are zero and `is_complete` is false."""

    def __init__(self, payload: bytes, position: int = 0) -> None:
        self._payload = payload
        self._position = position

    @property
    def left_bytes(self) -> int:
        return max(len(self._payload) - self._position, 0)

    @property
    def is_complete(self) -> bool:
        """Whether every byte was read exactly once."""
        return self._position == len(self._payload)

    def number(self, form: struct.Struct) -> int:
        if self.left_bytes < form.size:
            return self._fail()
        value: int = form.unpack_from(self._payload, self._position)[0]
        self._position += form.size
        return value

    def array(self, code: str) -> tuple[Any, ...]:
        count = self.number(_COUNT)
        if count * 4 > self.left_bytes:
            self._fail()
            return ()
        data = self._payload[self._position : self._position + count * 4]
        self._position += count * 4
        return struct.unpack(f"<{count}{code}", data)

    def text(self, max_bytes: int, errors: str = "strict") -> str:
        size = self.number(_COUNT)
        if size > min(max_bytes, self.left_bytes):
            self._fail()
            return ""
        data = self._payload[self._position : self._position + size]
        self._position += size
        try:
            return data.decode("utf-8", errors)
        except UnicodeDecodeError:
            self._fail()
            return ""

    def _fail(self) -> int:
        self._position = len(self._payload) + 1
        return 0
