"""Connection headers, messages and service answers of TCPROS: refused with our errors, however cut."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rostether.errors import RostetherError
from rostether.tcpros.handshake import purpose_of
from rostether.tcpros.header import HeaderDecoder, decode_fields, encode_header
from rostether.tcpros.message_framing import MessageDecoder, encode_messages
from rostether.tcpros.service_framing import AnswerDecoder, encode_error, encode_response


def seeds() -> list[bytes]:
    """Return a header, messages and answers."""
    fields = {"callerid": "/a", "topic": "/b", "md5sum": "*", "type": "std_msgs/String"}
    return [
        b"\x80" + encode_header(fields) + encode_messages([b"abc"]),
        b"\x80" + encode_messages([b"abc", b"", b"x" * 100]),
        b"\x80" + encode_response(b"abc") + encode_error("failed"),
    ]


def run(data: bytes) -> None:
    """Read as all three kinds of stream."""
    middle = data[0] * (len(data) - 1) // 256 if data else 0
    stream = data[1:]
    for make in (MessageDecoder, AnswerDecoder):
        assert _outcome(make, [stream]) == _outcome(make, [stream[:middle], stream[middle:]])
    header = HeaderDecoder()
    try:
        for part in (stream[:middle], stream[middle:]):
            fields = header.feed(part)
            if fields is not None:
                purpose_of(fields)
                break
        decode_fields(stream)
    except RostetherError as error:
        assert "\n" not in str(error)


def _outcome(make: Callable[[], Any], parts: list[bytes]) -> list[object]:
    decoder, found = make(), []
    try:
        for part in parts:
            found += decoder.feed(part)
    except RostetherError as error:
        assert "\n" not in str(error)
        # Which whole items came out before a broken one depends on the chunks.
        return [type(error)]
    return found
