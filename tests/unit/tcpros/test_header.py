"""Connection headers."""

from __future__ import annotations

import contextlib
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.errors import RemoteProtocolError
from rostether.tcpros.header import MAX_HEADER_BYTES, HeaderDecoder, decode_fields, encode_header

FIELDS = {"topic": "/chatter", "md5sum": "*", "message_definition": "string data\n", "empty": ""}


def test_layout_is_length_then_sorted_fields_with_their_lengths() -> None:
    assert encode_header({"b": "2", "a": "=x"}) == b"\x0f\0\0\0" + b"\x04\0\0\0a==x" + b"\x03\0\0\0b=2"


def test_fields_survive_every_cut() -> None:
    wire = encode_header(FIELDS) + b"tail"
    for cut in range(len(wire) + 1):
        decoder = HeaderDecoder()
        first = decoder.feed(wire[:cut])
        fields = first if first is not None else decoder.feed(wire[cut:])
        assert fields == FIELDS
        assert decoder.rest + (wire[cut:] if first is not None else b"") == b"tail"


def test_bytes_that_are_not_utf8_survive() -> None:
    body = encode_header({})[4:] + b"\x04\0\0\0k=\xff\xfe"
    assert encode_header(decode_fields(body))[4:] == body


def test_a_header_without_fields_is_complete() -> None:
    assert HeaderDecoder().feed(b"\0\0\0\0") == {}


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (b"\x01\0", "ends inside a field's length"),
        (b"\x09\0\0\0a=b", "claims 9 bytes, but only 3"),
        (b"\x03\0\0\0abc", "has no '='"),
        (b"\0\0\0\0", "has no '='"),
        (b"\x01\0\0\0=" * 65, "more than 64 fields"),
        (struct.pack("<I", 300) + b"k" * 299 + b"=", "has no '='"),
        (struct.pack("<I", 16391) + b"topic=" + b"x" * 16385, "field 'topic' is longer than 16384 bytes"),
    ],
)
def test_broken_fields_are_refused(body: bytes, reason: str) -> None:
    with pytest.raises(RemoteProtocolError, match=reason):
        decode_fields(body)


def test_a_length_above_the_limit_is_refused_before_its_bytes_arrive() -> None:
    with pytest.raises(RemoteProtocolError, match="not a TCPROS peer"):
        HeaderDecoder().feed(struct.pack("<I", MAX_HEADER_BYTES + 1))
    with pytest.raises(RemoteProtocolError):
        HeaderDecoder().feed(b"GET / HTTP/1.1\r\n")


@given(st.binary(max_size=200))
def test_garbage_is_refused_or_read_but_nothing_else_happens(data: bytes) -> None:
    with contextlib.suppress(RemoteProtocolError):
        HeaderDecoder().feed(data)
    with contextlib.suppress(RemoteProtocolError):
        fields = decode_fields(data)
        # The last value of a repeated key counts; all others are equal.
        assert decode_fields(encode_header(fields)[4:]) == fields


def test_the_bytes_of_an_unfinished_header_are_counted() -> None:
    decoder = HeaderDecoder()
    decoder.feed(encode_header(FIELDS)[:-1])
    assert decoder.held_bytes == len(encode_header(FIELDS)) - 1
