"""Reads TOML files that users write, within limits."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from rostether.errors import ConfigError
from rostether.mechanisms.text import read_failure

# Settings of a thousand boards or sensors take about 200 KB; a larger file is a mistake.
MAX_FILE_BYTES = 1024 * 1024

# The time for a dotted key grows with the square of the number of its parts: 50,000 parts take minutes.
# Keys in use have three.
MAX_KEY_PARTS = 32


def read_toml_text(path: Path) -> str:
    """Return the text of a file. Raises ConfigError."""
    try:
        with path.open("rb") as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise ConfigError(read_failure(path, error)) from error
    if len(data) > MAX_FILE_BYTES:
        raise ConfigError(f"{path}: longer than {MAX_FILE_BYTES} bytes; check that it is the right file")
    try:
        # Editors of Windows write a byte order mark.
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not UTF-8 text at byte {error.start}; save it as UTF-8") from None


def parse_toml(text: str, file: str) -> dict[str, Any]:
    """Return the content of a TOML text; `file` is its name in errors. Raises ConfigError."""
    for number, line in enumerate(text.splitlines(), 1):
        if line.partition("=")[0].count(".") >= MAX_KEY_PARTS:
            raise ConfigError(f"{file}: line {number}: a key has more than {MAX_KEY_PARTS} parts; shorten it")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ConfigError(f"{file}: not TOML: brackets are nested too deeply; flatten them") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{file}: not TOML: {error}") from None
    except ValueError:
        raise ConfigError(f"{file}: not TOML: a number has too many digits; shorten it") from None
