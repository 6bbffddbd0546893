"""Reads files that the user names, and lines and YAML documents of standard input, within limits."""

from __future__ import annotations

import asyncio
import os
import stat
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TextIO

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure

# Larger than any message or parameter; /dev/zero and pipes are endless.
MAX_FILE_BYTES = 64 << 20

STDIN = Path("-")

# Commands are short; a longer line is not a command.
MAX_LINE_BYTES = 1 << 16
# What a pipe holds on Linux.
_READ_BYTES = 1 << 16
# How often a background job checks whether the user has brought it to the foreground (`fg`).
_BACKGROUND_S = 1.0
# The pause between two reads of a file, in which other tasks run.
_FILE_PAUSE_S = 0.01

# Ends a YAML document.
SEPARATOR = "---"

# Larger than any usual message as text; without a limit a pipe could fill memory.
MAX_DOCUMENT_BYTES = 64 << 20


def read_bytes(file: Path) -> bytes:
    """Return the contents of a file; `-` is standard input. Raises ConfigError."""
    try:
        if file == STDIN:
            data = sys.stdin.buffer.read(MAX_FILE_BYTES + 1)
        else:
            with file.open("rb") as opened:
                data = opened.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        raise ConfigError(read_failure(file, error)) from None
    if len(data) > MAX_FILE_BYTES:
        raise ConfigError(f"{file} is larger than {MAX_FILE_BYTES >> 20} MiB; split it into several files")
    return data


def read_text(file: Path) -> str:
    """Return the text of a file, with each line end as `\\n`; `-` is standard input. Raises ConfigError."""
    try:
        text = read_bytes(file).decode("utf-8")
    except UnicodeDecodeError as error:
        raise ConfigError(
            f"{file}: not UTF-8 text ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


async def input_lines() -> AsyncIterator[str]:
    """Yield the lines of standard input until its end; none if it is closed."""
    if sys.stdin is None or sys.stdin.closed:
        return
    descriptor = sys.stdin.fileno()
    rest = b""
    while chunk := await _read(descriptor):
        *lines, rest = (rest + chunk).split(b"\n")
        for line in lines:
            yield line.decode(errors="replace")
        rest = rest[:MAX_LINE_BYTES]
    if rest:
        yield rest.decode(errors="replace")


async def _read(descriptor: int) -> bytes:
    """Wait for input and return it; nothing at its end.

    A file, or /dev/null, is always ready and cannot be watched.
    """
    loop = asyncio.get_running_loop()
    while True:
        ready = asyncio.Event()
        try:
            loop.add_reader(descriptor, ready.set)
        except PermissionError:
            # Without a pause, endless input such as /dev/zero would block the loop.
            await asyncio.sleep(_FILE_PAUSE_S)
            break
        try:
            await ready.wait()
        finally:
            loop.remove_reader(descriptor)
        if not is_background_job(descriptor):
            break
        await asyncio.sleep(_BACKGROUND_S)
    try:
        return os.read(descriptor, _READ_BYTES)
    except OSError:
        return b""


def is_background_job(terminal: int) -> bool:
    """Return whether the shell would stop this process for reading from its terminal or changing it."""
    try:
        return os.tcgetpgrp(terminal) != os.getpgrp()
    except OSError:
        # The descriptor is not a terminal, or the terminal of another session.
        return False


async def piped_documents(stream: TextIO) -> AsyncIterator[str]:
    """Yield the text of each document at its closing `---`, the last one at the end; skip empty ones.

    The event loop keeps running while a pipe is silent. Raises ConfigError for a document that is too large.
    """
    lines: list[str] = []
    size = 0
    async for line in _lines(stream):
        if line.rstrip() != SEPARATOR:
            lines.append(line)
            size += len(line)
            if size > MAX_DOCUMENT_BYTES:
                raise _too_long()
            continue
        if text := _joined(lines):
            yield text
        lines.clear()
        size = 0
    if text := _joined(lines):
        yield text


def _too_long() -> ConfigError:
    return ConfigError(
        f"a YAML document is larger than {MAX_DOCUMENT_BYTES:,} bytes; separate messages with {SEPARATOR}"
    )


def _joined(lines: list[str]) -> str:
    text = "".join(lines)
    return text if text.strip() else ""


async def _lines(stream: TextIO) -> AsyncIterator[str]:
    descriptor = _pipe_descriptor(stream)
    if descriptor is None:
        # Files and /dev/null are always ready, and the loop cannot watch them.
        while line := stream.readline(MAX_DOCUMENT_BYTES + 1):
            yield line
        return
    rest = bytearray()
    while chunk := await _read(descriptor):
        *line_ends, begin = chunk.split(b"\n")
        for line_end in line_ends:
            yield (rest + line_end + b"\n").decode("utf-8", "surrogateescape")
            rest.clear()
        rest += begin
        if len(rest) > MAX_DOCUMENT_BYTES:
            raise _too_long()
    yield rest.decode("utf-8", "surrogateescape")


def _pipe_descriptor(stream: TextIO) -> int | None:
    if os.name == "nt":
        return None
    try:
        descriptor = stream.fileno()
    except (OSError, AttributeError):
        return None
    mode = os.fstat(descriptor).st_mode
    return descriptor if stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode) else None
