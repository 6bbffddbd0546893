from __future__ import annotations

import asyncio
import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, TextIO

import pytest

from rostether.cli.shell.piped_documents import piped_documents
from rostether.errors import ConfigError


@pytest.fixture
def pipe() -> Iterator[tuple[TextIO, BinaryIO]]:
    """Both ends of a pipe."""
    reading, writing = os.pipe()
    with os.fdopen(reading) as stream, os.fdopen(writing, "wb", buffering=0) as end:
        yield stream, end


async def test_each_document_comes_when_its_separator_has_come(pipe: tuple[TextIO, BinaryIO]) -> None:
    stream, end = pipe
    documents = piped_documents(stream)
    end.write(b"a: 1\nb: 2\n--")
    first = asyncio.ensure_future(anext(documents))
    done, _ = await asyncio.wait([first], timeout=0.02)
    assert not done
    end.write(b"-\nc: \xc3\xa4\n")
    assert await first == "a: 1\nb: 2\n"
    end.close()
    assert [each async for each in documents] == ["c: ä\n"]
    assert os.get_blocking(stream.fileno())


async def test_a_line_beyond_all_measure_is_refused(
    pipe: tuple[TextIO, BinaryIO], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.cli.shell.piped_documents.MAX_DOCUMENT_BYTES", 100)
    stream, end = pipe
    end.write(b"x" * 1000)
    with pytest.raises(ConfigError, match="larger than 100 bytes"):
        await anext(piped_documents(stream))


@pytest.mark.parametrize(
    ("text", "documents"),
    [
        ("", []),
        ("---\n", []),
        ("a: 1", ["a: 1"]),
        ("a: 1\n---\n---\n \n--- \nb: 2\n---", ["a: 1\n", "b: 2\n"]),
        ("text: '-----'\n", ["text: '-----'\n"]),
    ],
)
async def test_documents_of_a_file(text: str, documents: list[str], tmp_path: Path) -> None:
    assert [each async for each in piped_documents(io.StringIO(text))] == documents
    file = tmp_path / "file"
    file.write_text(text)
    with file.open() as stream:
        assert [each async for each in piped_documents(stream)] == documents


async def test_nothing_comes_from_the_null_device() -> None:
    with Path(os.devnull).open() as stream:
        assert [each async for each in piped_documents(stream)] == []


@pytest.mark.parametrize("path", ["/dev/zero", "many lines"])
async def test_a_document_without_end_is_refused(
    path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.cli.shell.piped_documents.MAX_DOCUMENT_BYTES", 100)
    (tmp_path / "many lines").write_text("a: 1\n" * 100)
    with (tmp_path / path).open() as file, pytest.raises(ConfigError, match="separate messages with ---"):
        [text async for text in piped_documents(file)]
