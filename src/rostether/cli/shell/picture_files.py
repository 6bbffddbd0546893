"""Formats of pictures: the one that a file name gives, and pictures in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rostether.pictures.scene import Scene

SUFFIXES = {".svg": "svg", ".png": "png", ".dot": "dot", ".txt": "text"}


def picture_format(file: Path, known: tuple[str, ...] = tuple(SUFFIXES)) -> str:
    """Return the format that a file's name gives. Raises UsageError for a suffix that is not in `known`."""
    suffix = file.suffix.lower()
    if suffix not in known:
        raise click.UsageError(
            f"cannot determine the format of {file}; its name must end with {', '.join(known)}"
        )
    return SUFFIXES[suffix]


def encode(scene: Scene, kind: str) -> str | bytes:
    """Return a scene as `svg` or `png`. Raises ConfigError if a PNG cannot be drawn, see `png`."""
    if kind == "svg":
        from rostether.pictures.png import svg

        return svg(scene)
    from rostether.pictures.png import png

    return png(scene)
