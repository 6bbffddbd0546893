"""Joins the .ino files of a sketch into one C++ source; errors keep the line numbers of the .ino files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from msgspec import Struct

from rostether.firmware.cpp_tokens import tokenize
from rostether.firmware.prototypes import find_prototypes

_LINE_MARKER = re.compile(r'#(?:line)? (\d+) "((?:[^"\\]|\\.)*)"')


class InoFile(Struct, frozen=True):
    """One file of a sketch: its path as shown in errors, and its text with LF line ends."""

    path: str
    text: str


def read_ino(path: Path) -> InoFile:
    """Read a file. Bytes that are not UTF-8 stay unchanged; a byte order mark is removed."""
    text = path.read_bytes().decode("utf-8", "surrogateescape").removeprefix("\ufeff")
    return InoFile(str(path), text.replace("\r\n", "\n").replace("\r", "\n"))


def join(files: Sequence[InoFile]) -> str:
    """Return `#include <Arduino.h>` and the files in order, without prototypes."""
    return "".join(["#include <Arduino.h>\n", *(_line(1, each) + _complete(each.text) for each in files)])


def add_prototypes(files: Sequence[InoFile], active: dict[str, set[int]] | None) -> str:
    """Return the result of `join`, with prototypes for functions that are used before their definition.

    `active` has the lines that the preprocessor keeps, by path; None means all lines.
    """
    texts = [_complete(each.text) for each in files]
    starts = [sum(map(len, texts[:index])) for index in range(len(texts))]
    joined = "".join(texts)
    visible = "".join(
        text if active is None else _blank_inactive(text, active.get(each.path, set()))
        for each, text in zip(files, texts, strict=True)
    )

    def origin(offset: int) -> tuple[InoFile, int, int]:
        index = max(i for i, start in enumerate(starts) if start <= offset)
        before = joined[starts[index] : offset]
        return files[index], before.count("\n") + 1, len(before) - before.rfind("\n") - 1

    prototypes = find_prototypes(visible)
    # The order at one offset: start of a file, prototypes, then back to the user's line.
    edits = [(start, start, _line(1, file)) for start, file in zip(starts, files, strict=True)]
    for prototype in prototypes:
        file, line, _ = origin(prototype.definition_offset)
        edits.append((prototype.offset, prototype.offset, f"\n{_line(line, file)}{prototype.text}\n"))
        edits += [(start, end, re.sub(r"[^\n]", " ", joined[start:end])) for start, end in prototype.moved]
    for offset in dict.fromkeys(prototype.offset for prototype in prototypes):
        file, line, column = origin(offset)
        edits.append((offset, offset, _line(line, file) + " " * column))
    return "#include <Arduino.h>\n" + _edit(joined, edits)


def active_lines(preprocessed: str) -> dict[str, set[int]]:
    """Return the lines of each file that `-E -fdirectives-only` keeps."""
    active: dict[str, set[int]] = {}
    current: set[int] = set()
    number = 0
    for line in preprocessed.splitlines():
        marker = _LINE_MARKER.match(line)
        if marker is not None:
            number = int(marker[1])
            path = re.sub(r"\\(.)", r"\1", marker[2])
            current = active.setdefault(path, set())
            continue
        if line.strip():
            current.add(number)
        number += 1
    return active


def _edit(text: str, edits: list[tuple[int, int, str]]) -> str:
    parts = []
    position = 0
    for start, end, new in sorted(edits, key=lambda edit: edit[0]):
        parts += [text[position:start], new]
        position = end
    return "".join([*parts, text[position:]])


def _line(number: int, file: InoFile) -> str:
    path = file.path.replace("\\", "\\\\").replace('"', '\\"')
    return f'#line {number} "{path}"\n'


def _complete(text: str) -> str:
    return text if text.endswith("\n") else text + "\n"


def _blank_inactive(text: str, active: set[int]) -> str:
    lines = text.split("\n")
    directive_lines = set(_lines_of_directives(text))
    was_active = False
    for index, line in enumerate(lines):
        continues = index > 0 and lines[index - 1].endswith("\\") and was_active
        was_active = index + 1 in active or continues
        if not was_active and index + 1 not in directive_lines:
            lines[index] = " " * len(line)
    return "\n".join(lines)


def _lines_of_directives(text: str) -> Iterator[int]:
    for token in tokenize(text):
        if token.kind == "directive":
            first = text.count("\n", 0, token.offset) + 1
            yield from range(first, first + token.text.count("\n") + 1)
