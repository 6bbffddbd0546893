"""Improves the compiler's output: paths as the user typed them, and hints on beginners' errors."""

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
# A second directive, or code, after an #include; after a comment, the functions that every sketch has.
_JOINED = re.compile(
    r"^[ \t]*#[ \t]*include[ \t]*(?:<[^<>\n]+>|\"[^\"\n]+\")[ \t]*(?P<rest>(?!//|/\*)\S.*)$"
    r"|^[ \t]*#[ \t]*define[ \t].*?(?P<second>#[ \t]*(?:include|define)[ \t].*)$"
    r"|^[^\"\n]*//.*?(?P<code>void[ \t]+(?:setup|loop)[ \t]*\(.*)$",
    re.MULTILINE,
)
_TYPE_HEADER = re.compile(r"\w+_(?:msgs|srvs)/\w+\.h")


def explain(output: str, sketch: Sketch, skipped: Sequence[str] = ()) -> str:
    """Return a compiler's output with added hints in the same format.

    `skipped` has the reasons why messages could not be generated; it is shown if a header is missing.
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
    """Return an error for each line that joins several lines, as copy buttons of web pages do."""
    found = []
    for match in _JOINED.finditer(text):
        group = next(name for name in ("rest", "second", "code") if match[name])
        line = text.count("\n", 0, match.start()) + 1
        place = f"{path}:{line}:{match.start(group) - match.start() + 1}"
        what = "a web page joined several lines into this one; start a new line before"
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
    """Write paths below the current folder as relative paths, as the user typed them."""
    try:
        prefix = os.path.relpath(folder)
    except (ValueError, OSError):
        return text
    if prefix.startswith(".."):
        return text
    return text.replace(f"{folder}{os.sep}", "" if prefix == "." else f"{prefix}{os.sep}")
