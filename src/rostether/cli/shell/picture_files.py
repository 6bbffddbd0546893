"""Pictures in files: which format a name means, and writing it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.pictures.scene import Scene

SUFFIXES = {".svg": "svg", ".png": "png", ".dot": "dot", ".txt": "text"}


def picture_format(file: Path, known: tuple[str, ...] = tuple(SUFFIXES)) -> str:
    """Return the format that a file's name means. Raises UsageError for none of the known suffixes."""
    suffix = file.suffix.lower()
    if suffix not in known:
        raise click.UsageError(f"{file} does not say what it shall be: end it with {', '.join(known)}")
    return SUFFIXES[suffix]


def encode(scene: Scene, kind: str) -> str | bytes:
    """Return a scene as `svg` or `png`. Raises ConfigError when it is too large for that."""
    if kind == "svg":
        from rostether.pictures.svg import svg

        return svg(scene)
    from rostether.pictures.png import png

    return png(scene)


def save(file: Path, content: str | bytes) -> None:
    """Write a file. Raises ConfigError when that is not possible."""
    data = content.encode(errors="replace") if isinstance(content, str) else content
    try:
        file.write_bytes(data)
    except OSError as error:
        raise ConfigError(f"{file} cannot be written: {error.strerror}") from None
