"""What the compiler printed, with paths as the user knows them and a word on what novices meet."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

from rostether.firmware.ino import read_ino
from rostether.firmware.sketch import Sketch
from rostether.firmware.typography import MAX_REPORTED, find_typographic

_MISSING_HEADER = re.compile(r"fatal error: (\S+): No such file or directory")
_UNDECLARED = re.compile(r"'(\w+)' was not declared")
# A second directive, or code, behind an #include; behind a comment, what every sketch has.
_JOINED = re.compile(
    r"^[ \t]*#[ \t]*include[ \t]*(?:<[^<>\n]+>|\"[^\"\n]+\")[ \t]*(?P<rest>(?!//|/\*)\S.*)$"
    r"|^[ \t]*#[ \t]*define[ \t].*?(?P<second>#[ \t]*(?:include|define)[ \t].*)$"
    r"|^[^\"\n]*//.*?(?P<code>void[ \t]+(?:setup|loop)[ \t]*\(.*)$",
    re.MULTILINE,
)
_TYPE_HEADER = re.compile(r"\w+_(?:msgs|srvs)/\w+\.h")


def explain(output: str, sketch: Sketch, skipped: Sequence[str] = ()) -> str:
    """Return a compiler's output with causes that it does not name around it, in its own form.

    `skipped` says why messages could not be made; it counts where a header is missing.
    """
    lines = []
    if "stray" in output or "missing terminating" in output or "expects" in output:
        for path in [*sketch.inos, *sketch.sources]:
            text = read_ino(path).text
            lines += [each.explain(str(path)) for each in find_typographic(text)]
    if "error" in output or "undefined reference" in output:
        for path in [*sketch.inos, *sketch.sources]:
            lines += _joined_lines(read_ino(path).text, str(path))
    lines += output.splitlines()
    lines += [_explain_pin(name) for name in dict.fromkeys(_UNDECLARED.findall(output)) if _is_opencr(name)]
    missing = dict.fromkeys(_MISSING_HEADER.findall(output))
    lines += [_explain_header(header) for header in missing]
    lines += [f"note: {each}" for each in skipped if missing]
    text = "".join(f"{line}\n" for line in lines)
    return _shorten(text, sketch.folder)


def _joined_lines(text: str, path: str) -> list[str]:
    """Return a line for each line of a sketch that holds several; a web page's copy button makes them."""
    found = []
    for match in _JOINED.finditer(text):
        group = next(name for name in ("rest", "second", "code") if match[name])
        line = text.count("\n", 0, match.start()) + 1
        place = f"{path}:{line}:{match.start(group) - match.start() + 1}"
        what = "a web page joined several lines into this one; begin a new line before"
        found.append(f"{place}: error: {what} `{match[group][:30].strip()}`")
    return found[:MAX_REPORTED]


def _is_opencr(name: str) -> bool:
    return name.startswith("BDPIN_")


def _explain_pin(name: str) -> str:
    return f"note: {name} is a pin of the OpenCR; build with --board opencr, or name a pin here: -D {name}=13"


def _explain_header(header: str) -> str:
    if _TYPE_HEADER.fullmatch(header):
        return (
            f"note: no package contains {header}; give the folder of its .msg and .srv files with --msg-path"
            f" DIR"
        )
    return f"note: no library contains {header}; give the folder of the library with --library DIR"


def _shorten(text: str, folder: Path) -> str:
    """Write paths relative to the current folder where they are below it, as the user typed them."""
    try:
        prefix = os.path.relpath(folder)
    except (ValueError, OSError):
        return text
    if prefix.startswith(".."):
        return text
    return text.replace(f"{folder}{os.sep}", "" if prefix == "." else f"{prefix}{os.sep}")
