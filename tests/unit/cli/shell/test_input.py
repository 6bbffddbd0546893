from __future__ import annotations

import asyncio
import io
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, TextIO

import pytest

from rostether.cli.shell.input import (
    MAX_FILE_BYTES,
    STDIN,
    input_lines,
    piped_documents,
    read_bytes,
    read_text,
)
from rostether.errors import ConfigError


def test_a_file_and_standard_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "values.yaml"
    file.write_bytes("a: ü\r\n".encode())
    assert read_text(file) == "a: ü\n"
    assert read_bytes(file) == "a: ü\r\n".encode()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"b: 1")))
    assert read_text(STDIN) == "b: 1"


@pytest.mark.parametrize("name", ["", "missing", "latin1"])
def test_unreadable_files_are_reported_in_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "latin1").write_bytes(b"\xff")
    with pytest.raises(ConfigError, match=r"No such file|; give a file in this folder|not UTF-8"):
        read_text(tmp_path / name)


@pytest.mark.skipif(sys.platform == "win32", reason="has no /dev/zero")
def test_a_file_without_end_is_refused() -> None:
    with pytest.raises(ConfigError, match=f"larger than {MAX_FILE_BYTES >> 20} MiB"):
        read_bytes(Path("/dev/zero"))


async def test_lines_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "commands"
    file.write_text("one\ntwo")
    with file.open() as opened:
        monkeypatch.setattr(sys, "stdin", opened)
        assert [line async for line in input_lines()] == ["one", "two"]


@pytest.mark.skipif(sys.platform == "win32", reason="has no /dev/zero")
async def test_input_without_end_leaves_the_loop_free(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path("/dev/zero").open() as opened:
        monkeypatch.setattr(sys, "stdin", opened)
        reading = asyncio.ensure_future(anext(aiter(input_lines())))
        # The loop runs again only if reading yielded to it before.
        for _ in range(100):
            await asyncio.sleep(0)
        assert not reading.done()
        reading.cancel()
        await asyncio.wait({reading})


@pytest.fixture
def pipe() -> Iterator[tuple[TextIO, BinaryIO]]:
    """Both ends of a pipe."""
    reading, writing = os.pipe()
    with os.fdopen(reading) as stream, os.fdopen(writing, "wb", buffering=0) as end:
        yield stream, end


async def test_each_document_is_read_once_its_separator_arrives(pipe: tuple[TextIO, BinaryIO]) -> None:
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


async def test_a_line_without_end_is_refused(
    pipe: tuple[TextIO, BinaryIO], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rostether.cli.shell.input.MAX_DOCUMENT_BYTES", 100)
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
    monkeypatch.setattr("rostether.cli.shell.input.MAX_DOCUMENT_BYTES", 100)
    (tmp_path / "many lines").write_text("a: 1\n" * 100)
    with (tmp_path / path).open() as file, pytest.raises(ConfigError, match="separate messages with ---"):
        [text async for text in piped_documents(file)]
