"""Connection headers, messages and service answers of TCPROS: refused with our errors, in any chunks.

Limits are low. Simple readers that follow the specification determine the content of a stream.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable
from typing import Any

from fuzz.grammar import near, string
from fuzz.lowering import lowered
from rostether.errors import RostetherError
from rostether.tcpros import header as header_module
from rostether.tcpros.handshake import purpose_of
from rostether.tcpros.header import HeaderDecoder, encode_header
from rostether.tcpros.message_framing import MessageDecoder, encode_messages
from rostether.tcpros.service_framing import AnswerDecoder, encode_error, encode_response

MAX_MESSAGE_BYTES = 64
MAX_HEADER_BYTES = 256
MAX_FIELDS, MAX_KEY_BYTES, MAX_VALUE_BYTES = 8, 16, 48


def seeds() -> list[bytes]:
    """Return a header, messages and answers."""
    fields = {"callerid": "/a", "topic": "/b", "md5sum": "*", "type": "std_msgs/String"}
    return [
        b"\x80" + encode_header(fields) + encode_messages([b"abc"]),
        b"\x80" + encode_messages([b"abc", b"", b"x" * 100]),
        b"\x80" + encode_response(b"abc") + encode_error("failed"),
    ]


def generate(source: random.Random) -> bytes:
    """Return one kind of stream, with lengths near the limits, and sometimes many messages of one length."""
    kind = source.randrange(3)
    parts: list[bytes] = []
    for _ in range(source.randint(1, 10)):
        size = near(source, MAX_MESSAGE_BYTES) if source.random() < 0.2 else source.randint(0, 9)
        item = struct.pack("<I", size) + source.randbytes(min(size, 80))
        if kind == 0:
            parts += [item] * source.choice((1, 1, 9))
        elif kind == 1:
            parts.append(bytes([source.choice((0, 1, 1, 2))]) + item)
    if kind == 2:
        fields = [_field(source) for _ in range(min(near(source, MAX_FIELDS), 12))]
        body = b"".join(string(field) for field in fields)
        parts = [struct.pack("<I", near(source, MAX_HEADER_BYTES)) if source.random() < 0.1 else b"", body]
        parts[0] = parts[0] or struct.pack("<I", len(body))
    return source.randbytes(1) + b"".join(parts)


def _field(source: random.Random) -> bytes:
    key = source.choice((b"topic", b"service", b"md5sum", b"type", b"message_definition", b"k"))
    if source.random() < 0.2:
        key = b"k" * (near(source, MAX_KEY_BYTES) % 20)
    size = near(source, MAX_VALUE_BYTES) % 64 if source.random() < 0.2 else source.randint(0, 5)
    return key + source.choice((b"=", b"=", b"=", b"")) + b"v" * size


def run(data: bytes) -> None:
    """Read the data as all three kinds of stream."""
    middle = data[0] * (len(data) - 1) // 256 if data else 0
    stream = data[1:]
    for make, head_bytes in ((MessageDecoder, 4), (AnswerDecoder, 5)):
        expected = _items(stream, head_bytes)
        for parts in ([stream], [stream[:middle], stream[middle:]]):
            found = _outcome(make, parts)
            assert found == expected, (
                f"{make.__name__}: the decoder and the simple reader find different items"
            )
    limits = {"MAX_FIELDS": MAX_FIELDS, "MAX_KEY_BYTES": MAX_KEY_BYTES, "MAX_VALUE_BYTES": MAX_VALUE_BYTES}
    with lowered(header_module, **limits):
        _read_header(stream, middle)


def _outcome(make: Callable[[int], Any], parts: list[bytes]) -> list[bytes] | None:
    """Return the items that a decoder finds, None if it refuses the stream."""
    decoder, found = make(MAX_MESSAGE_BYTES), []
    try:
        for part in parts:
            found += decoder.feed(part)
    except RostetherError as error:
        assert "\n" not in str(error)
        return None
    return [each if isinstance(each, bytes) else bytes([each.is_ok]) + each.payload for each in found]


def _items(stream: bytes, head_bytes: int) -> list[bytes] | None:
    """Return the payloads in a stream of lengths and payloads, None if it must be refused."""
    found, place = [], 0
    while len(stream) - place >= head_bytes:
        start = place + head_bytes
        size = int.from_bytes(stream[start - 4 : start], "little")
        if size > MAX_MESSAGE_BYTES:
            return None
        if start + size > len(stream):
            break
        is_ok = bytes([bool(stream[place])]) if head_bytes > 4 else b""
        found.append(is_ok + stream[start : start + size])
        place = start + size
    return found


def _read_header(stream: bytes, middle: int) -> None:
    decoder = HeaderDecoder(MAX_HEADER_BYTES)
    fields: dict[str, str] | None = None
    is_refused = False
    try:
        for part in (stream[:middle], stream[middle:]):
            fields = decoder.feed(part)
            assert decoder.held_bytes <= MAX_HEADER_BYTES + 4, "more bytes are kept than a header may have"
            if fields is not None:
                break
    except RostetherError as error:
        assert "\n" not in str(error)
        is_refused = True
    if len(stream) < 4:
        return
    size = int.from_bytes(stream[:4], "little")
    if size > MAX_HEADER_BYTES:
        assert is_refused, "a header that is too long is not refused"
    elif len(stream) >= 4 + size:
        expected = _fields(stream[4 : 4 + size])
        assert is_refused == (expected is None), "the decoder and the simple reader differ about a header"
        assert is_refused or fields == expected
        if fields is not None:
            try:
                purpose_of(fields)
            except RostetherError as error:
                assert "\n" not in str(error)


def _fields(body: bytes) -> dict[str, str] | None:
    found, count = {}, 0
    while body:
        count += 1
        size = int.from_bytes(body[:4], "little")
        field, rest = body[4 : 4 + size], body[4 + size :]
        key, equals, value = field.partition(b"=")
        is_text = key.strip() == b"message_definition"
        if len(body) < 4 or len(field) < size or not equals or len(key) >= MAX_KEY_BYTES:
            return None
        if count > MAX_FIELDS or (len(value) + 1 > MAX_VALUE_BYTES and not is_text):
            return None
        name = key.decode("utf-8", "surrogateescape").strip()
        found[name] = value.decode("utf-8", "surrogateescape")
        body = rest
    return found
