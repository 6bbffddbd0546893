"""Writes results: lines for users, and one JSON object per line for scripts."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TextIO, TypeAlias

import click

from rostether.cli.shell.failures import EXIT_DONE
from rostether.cli.shell.option_group import add_flag
from rostether.errors import ConfigError
from rostether.mechanisms.text import escape_text, write_failure
from rostether.mechanisms.whole_file import write_whole

json_option: Callable[[Any], Any] = add_flag("--json as_json", "Print one JSON object per line.")


Paint: TypeAlias = Callable[[str], str]

# A field or a label at the beginning of a line.
_KEY: Final = re.compile(r"^([ \t]*(?:- )?)([A-Za-z_][\w ]*:)(?= |$)", re.MULTILINE)
# The separator of messages.
_BETWEEN: Final = re.compile(r"^---$", re.MULTILINE)
# The branches of the tree, the name of the frame, and its facts.
_FRAME: Final = re.compile(r"^([\s│├└─]*)([^\s(]\S*)(.*)$")

# The first word of a line of a diagnosis.
_FINDINGS: Final = {
    "error": "red",
    "PROBLEM": "red",
    "warning": "yellow",
    "next": "cyan",
    "ok": "green",
    "no problem found": "green",
}
_FINDING: Final = re.compile(rf"^(\s*)({'|'.join(_FINDINGS)})\b")


def write_line(text: str = "", paint: Paint | None = None) -> None:
    """Write a line to stdout, colored by `paint` on a terminal, and flush it.

    Unprintable characters are escaped: names, values and errors from peers must not control the terminal.
    When the reader closes the pipe (`| head`), the command ends here with exit code 0.
    """
    shown = escape_text(text)
    if paint is not None and has_colors():
        shown = paint(shown)
    try:
        sys.stdout.write(shown + "\n")
        sys.stdout.flush()
    except BrokenPipeError:
        discard_output(sys.stdout)
        raise click.exceptions.Exit(EXIT_DONE) from None


def discard_output(stream: TextIO) -> None:
    """Discard all further output to a stream; the interpreter flushes it again at exit."""
    devnull = os.open(os.devnull, os.O_WRONLY)
    os.dup2(devnull, stream.fileno())
    os.close(devnull)


def warn(text: str) -> None:
    """Write a line to stderr."""
    sys.stdout.flush()
    sys.stderr.write(escape_text(text) + "\n")
    sys.stderr.flush()


def write_json(record: Mapping[str, object]) -> None:
    """Write one object as one line of JSON; `serde.plain_form` makes such objects of messages."""
    write_line(json.dumps(record, ensure_ascii=False, allow_nan=False))


def write_file(file: Path, content: str | bytes) -> None:
    """Create or replace a file; text becomes UTF-8. Raises ConfigError if that fails."""
    try:
        write_whole(file, content.encode(errors="replace") if isinstance(content, str) else content)
    except OSError as error:
        raise ConfigError(write_failure(file, error)) from None


def write_table(rows: Sequence[Sequence[str]], indent: str = "") -> None:
    """Write rows of cells, with columns as wide as their longest cells."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        write_line(f"{indent}{cells}".rstrip())


def write_result(record: Mapping[str, object], text: str, *, as_json: bool) -> None:
    """Write a result as an object for scripts, or as lines for users."""
    if as_json:
        write_json(record)
    else:
        write_line(text)


def write_finding(what: str, text: str, *, is_ok: bool | None, as_json: bool) -> None:
    """Write one result of an examination; `is_ok` is None for what could not be checked."""
    if as_json:
        write_json({"ok": is_ok, "what": what, "text": text})
    else:
        word = {True: "ok", False: "PROBLEM", None: "not checked"}[is_ok]
        write_line(f"{word}: {what}: {text}", paint_finding)


def has_colors() -> bool:
    """Return whether the output is a terminal whose user wants colors."""
    is_wanted = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return is_wanted and sys.stdout.isatty()


def shows_live() -> bool:
    """Return whether the output is a terminal that can show lines which change."""
    return sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")


def paint_keys(text: str) -> str:
    """Return YAML or labeled lines with colored keys."""
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
