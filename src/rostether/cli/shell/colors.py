"""Colors in the output for people: only on a terminal, and not if NO_COLOR is set (https://no-color.org)."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from typing import Final, TypeAlias

import click

Paint: TypeAlias = Callable[[str], str]

# A field or a label at the beginning of a line.
_KEY: Final = re.compile(r"^([ \t]*(?:- )?)([A-Za-z_][\w ]*:)(?= |$)", re.MULTILINE)
_BETWEEN: Final = re.compile(r"^---$", re.MULTILINE)
_FRAME: Final = re.compile(r"^([\s│├└─]*)([^\s(]\S*)(.*)$")

# What a line of a diagnosis begins with.
_FINDINGS: Final = {
    "error": "red",
    "PROBLEM": "red",
    "warning": "yellow",
    "next": "cyan",
    "ok": "green",
    "no problem found": "green",
}
_FINDING: Final = re.compile(rf"^(\s*)({'|'.join(_FINDINGS)})\b")


def has_colors() -> bool:
    """Return whether the output is a terminal whose user wants colors."""
    is_wanted = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return is_wanted and sys.stdout.isatty()


def paint_keys(text: str) -> str:
    """Return YAML or labelled lines with colored keys."""
    text = _KEY.sub(lambda found: found[1] + click.style(found[2], fg="cyan"), text)
    return _BETWEEN.sub(click.style("---", dim=True), text)


def paint_finding(line: str) -> str:
    """Return a line of a diagnosis with the color of its severity."""
    return _FINDING.sub(
        lambda found: found[1] + click.style(found[2], fg=_FINDINGS[found[2]], bold=True), line
    )


def paint_frame(line: str) -> str:
    """Return a line of a tree of frames with the frame's name in bold."""
    return _FRAME.sub(
        lambda found: found[1] + click.style(found[2], bold=True) + click.style(found[3], dim=True), line
    )
