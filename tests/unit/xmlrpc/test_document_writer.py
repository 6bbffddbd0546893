"""Writing XML-RPC documents in steps, with a limit."""

from __future__ import annotations

import xmlrpc.client

import pytest

from rostether.errors import SerializationError
from rostether.xmlrpc.document_writer import (
    DocumentTooLargeError,
    DocumentWriter,
    dump_response,
    response_steps,
)
from xmlrpc_documents import load_response


def steps_of(value: object) -> int:
    return sum(1 for _ in response_steps(DocumentWriter(), value))


def test_a_small_value_takes_no_step() -> None:
    assert steps_of([1, "current topics", [["/t", "std_msgs/String"]]]) == 0


@pytest.mark.parametrize(
    "value",
    [[1] * 100_000, {f"k{number}": number for number in range(100_000)}, "x" * 2_000_000, b"x" * 2_000_000],
    ids=["array", "struct", "string", "base64"],
)
def test_a_large_value_takes_steps(value: object) -> None:
    assert steps_of(value) >= 20


@pytest.mark.parametrize("value", ["<&>é\n" * 50_000, bytes(range(256)) * 1_000])
def test_what_is_written_in_pieces_reads_as_one(value: str | bytes) -> None:
    assert load_response(dump_response({"a": value, "b": [value, 1]})) == {"a": value, "b": [value, 1]}
    if isinstance(value, str):
        assert xmlrpc.client.loads(dump_response(value))[0] == (value,)


def test_an_iterator_is_written_as_an_array_without_none() -> None:
    assert load_response(dump_response([iter([1, None, [2]]), 3])) == [[1, [2]], 3]
    with pytest.raises(SerializationError, match="cannot carry None"):
        dump_response([None])


def test_a_document_has_a_limit() -> None:
    writer = DocumentWriter(max_bytes=1_000_000)
    written = 0
    with pytest.raises(DocumentTooLargeError, match="more than 1000000 bytes"):
        for _ in response_steps(writer, iter(lambda: "x" * 1000, None)):
            written += 1
    assert written < 20, "an endless value ends at the limit"


def test_a_rewind_drops_everything_after_the_mark() -> None:
    writer = DocumentWriter(max_bytes=100_000)
    writer.begin_response_array()
    writer.write_value(1)
    mark = writer.mark()
    writer.write_value("x" * 90_000)
    writer.rewind(mark)
    writer.write_value("y" * 90_000)
    writer.end_response_array()
    assert load_response(writer.document()) == [1, "y" * 90_000]
