"""Reads whole files given on the command line, up to a size limit."""

from __future__ import annotations

import sys
from pathlib import Path

from rostether.errors import ConfigError

# Larger than any message or parameter; /dev/zero and pipes are endless.
MAX_FILE_BYTES = 64 << 20

STDIN = Path("-")


def read_bytes(file: Path) -> bytes:
    """Return the contents of a file; `-` is standard input. Raises ConfigError."""
    try:
        if file == STDIN:
            data = sys.stdin.buffer.read(MAX_FILE_BYTES + 1)
        else:
            with file.open("rb") as opened:
                data = opened.read(MAX_FILE_BYTES + 1)
    except (FileNotFoundError, IsADirectoryError):
        raise ConfigError(f"there is no file {file}") from None
    except (OSError, ValueError) as error:
        raise ConfigError(f"cannot read {file}: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > MAX_FILE_BYTES:
        raise ConfigError(f"{file} is larger than {MAX_FILE_BYTES >> 20} MiB; split it into several files")
    return data


def read_text(file: Path) -> str:
    """Return the text of a file, with each line end as `\\n`; `-` is standard input. Raises ConfigError."""
    try:
        text = read_bytes(file).decode("utf-8")
    except UnicodeDecodeError as error:
        raise ConfigError(f"{file}: not UTF-8 text ({error.reason} at byte {error.start})") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")
