"""Writes pictures to files, in the format that the file name gives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.errors import ConfigError
from rostether.mechanisms.text import write_failure
from rostether.mechanisms.whole_file import write_whole

if TYPE_CHECKING:
    from rostether.pictures.scene import Scene

SUFFIXES = {".svg": "svg", ".png": "png", ".dot": "dot", ".txt": "text"}


def picture_format(file: Path, known: tuple[str, ...] = tuple(SUFFIXES)) -> str:
    """Return the format that a file's name gives. Raises UsageError for an unknown suffix."""
    suffix = file.suffix.lower()
    if suffix not in known:
        raise click.UsageError(
            f"cannot determine the format of {file}; its name must end with {', '.join(known)}"
        )
    return SUFFIXES[suffix]


def encode(scene: Scene, kind: str) -> str | bytes:
    """Return a scene as `svg` or `png`. Raises ConfigError when it is too large for that."""
    if kind == "svg":
        from rostether.pictures.png import svg

        return svg(scene)
    from rostether.pictures.png import png

    return png(scene)


def save(file: Path, content: str | bytes) -> None:
    """Write a file. Raises ConfigError if that fails."""
    data = content.encode(errors="replace") if isinstance(content, str) else content
    try:
        write_whole(file, data)
    except OSError as error:
        raise ConfigError(write_failure(file, error)) from None
