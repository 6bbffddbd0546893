"""Service answers."""

from __future__ import annotations

import struct

import pytest

from rostether.errors import RemoteProtocolError
from rostether.tcpros.service_framing import (
    MAX_ERROR_TEXT_BYTES,
    AnswerDecoder,
    ServiceAnswer,
    encode_error,
    encode_response,
)


def test_layout() -> None:
    assert encode_response(b"ab") == b"\x01\x02\0\0\0ab"
    assert encode_error("nö") == b"\0\x03\0\0\0n\xc3\xb6"


@pytest.mark.parametrize("size", [1, 2, 3, 7, 1000])
def test_answers_come_back_however_they_are_cut(size: int) -> None:
    wire = encode_response(b"") + encode_error("no") + encode_response(b"x" * 300)
    decoder = AnswerDecoder()
    answers = [each for i in range(0, len(wire), size) for each in decoder.feed(wire[i : i + size])]
    assert answers == [ServiceAnswer(True, b""), ServiceAnswer(False, b"no"), ServiceAnswer(True, b"x" * 300)]
    assert answers[1].error_text == "no"


def test_long_error_texts_are_cut() -> None:
    (answer,) = AnswerDecoder().feed(encode_error("x" * (MAX_ERROR_TEXT_BYTES + 9)))
    assert len(answer.payload) == MAX_ERROR_TEXT_BYTES


def test_a_length_above_the_limit_is_refused_before_its_bytes_arrive() -> None:
    with pytest.raises(RemoteProtocolError, match="more than 10"):
        AnswerDecoder(max_message_bytes=10).feed(struct.pack("<BI", 1, 11))


def test_an_error_text_that_is_not_utf8_can_still_be_read() -> None:
    assert ServiceAnswer(False, b"bad \xff").error_text == "bad \ufffd"
