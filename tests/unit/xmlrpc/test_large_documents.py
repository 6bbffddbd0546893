"""Large documents, and those that are expensive on purpose, are read in short steps or refused."""

from __future__ import annotations

import gc
import weakref

import pytest

from rostether.errors import RemoteProtocolError
from rostether.xmlrpc import document_reader
from rostether.xmlrpc.document_reader import (
    MAX_TAG_BYTES,
    MAX_VALUES,
    STEP_BYTES,
    DocumentReader,
    load_call,
)
from xmlrpc_documents import dump_call

pytestmark = pytest.mark.slow


def call(params: bytes) -> bytes:
    return b"<methodCall><methodName>m</methodName><params>" + params + b"</params></methodCall>"


def test_a_large_document_is_read_in_steps() -> None:
    params = ["x" * 100_000, list(range(10_000)), {str(key): "\u00e4<&>" for key in range(3_000)}]
    document = dump_call("setParam", params)
    reader = DocumentReader(document)
    assert sum(1 for _ in reader.steps()) == -(-len(document) // STEP_BYTES)
    assert reader.call() == ("setParam", params)


@pytest.mark.parametrize(
    "document",
    [
        call(b"<" + b"a" * 1_000_000 + b"/>"),
        b"<methodCall " + b"".join(b'a%d="" ' % number for number in range(50_000)) + b"/>",
        b"<!--" + b"- " * 500_000 + b"--><methodCall/>",
        b"<methodCall><?a " + b"b" * 1_000_000,
    ],
    ids=["name", "attributes", "comment", "instruction"],
)
def test_a_tag_without_an_end_is_refused_soon(document: bytes) -> None:
    steps = 0
    with pytest.raises(RemoteProtocolError, match=f"must not have tags of more than {MAX_TAG_BYTES} bytes"):
        for _ in DocumentReader(document).steps():
            steps += 1
    assert steps * STEP_BYTES <= MAX_TAG_BYTES + STEP_BYTES


def test_long_texts_are_not_long_tags() -> None:
    for text in (b"x" * 1_000_000, b"&amp;" * 200_000, b"\n" * 200_000):
        _, (value,) = load_call(call(b"<param><value>" + text + b"</value></param>"))
        assert isinstance(value, str)


@pytest.mark.parametrize(
    ("empty", "limit"), [(b"<value/>", MAX_VALUES), (b"<value><array><data/></array></value>", 1000)]
)
def test_values_are_counted(empty: bytes, limit: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(document_reader, "MAX_VALUES", limit)
    count = limit - 1
    document = b"<param><value><array><data>%s</data></array></value></param>"
    _, (values,) = load_call(call(document % (empty * count)))
    assert isinstance(values, list)
    assert len(values) == count
    with pytest.raises(RemoteProtocolError, match=f"at most {limit} values"):
        load_call(call(document % (empty * (count + 1))))


def test_a_document_that_was_read_leaves_no_work_for_the_garbage_collector() -> None:
    reader = DocumentReader(b"<methodCall><methodName>getPid</methodName></methodCall>")
    for _ in reader.steps():
        pass
    alive = weakref.ref(reader)
    gc.disable()
    try:
        del reader
        assert alive() is None
    finally:
        gc.enable()
