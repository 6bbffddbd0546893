"""A documentation page as its reader sees it: which commands it tells to type, and what they print.

Fenced blocks count when their language is `sh` (commands, one per line, `\\` continues), followed or not by a
`text` block: lines that the last command prints, in that order. Numbers and times may differ, and lines that
not every run prints are not required. The attribute `test` of a block is for the tests, the build of the
pages removes it. On commands, "leave running" means that the last one is left running, as the reader would
leave it, "not run" marks those that need a board, and "on NAME" those that need a machine of that name. On
output, "varies" means that each run prints other lines between the first and the last. Titles that are names
of files mark what the reader is to save.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

_FENCE = re.compile(r"^```(?P<language>\w+)(?P<info>[^\n]*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
_MARK = re.compile(r' test="([^"]*)"')
_QUOTED = re.compile(r"'[^']*'|\"[^\"$`\\\\]*\"")
# What a shell expands, and what only a shell runs.
_NEEDS_SHELL = re.compile(r"[\"'$`\\\\~*?\[\]{}()<>|&;#]|^\w+=|^cd ")
_NOT_TYPED_HERE = re.compile(r'test="not run|test="on |title="[\w.]+\.sh"')

# What differs from run to run: bars, hexadecimal numbers with a digit, numbers, and widths of columns.
_VARYING = re.compile(
    r"(?P<bar>[█▒·▁▂▃▄▅▆▇]+(?:\s+[█▒·]+)*)|(?P<hex>\b(?=[a-f]*\d)[0-9a-f]{8,}\b)"
    r"|(?P<number>[+-]?(?:\b\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?|\b(?:inf|null)\b)(?:[kM]\b)?)|(?P<space>\s+)"
)
_PATTERNS = {
    "bar": r"[█▒·▁▂▃▄▅▆▇\s]*",
    "hex": r"[0-9a-f]+",
    "number": r"\s*[+-]?(?:\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?|inf|null)(?:[kM]\b)?",
    "space": r"\s*",
}
# What is printed on the first run only, or by commands that wait for others.
_NOT_IN_EVERY_RUN = re.compile(
    r"preparing a simulated |Building the sketch for |waiting: |not registered as \S+ yet: "
)


@dataclass(frozen=True, slots=True)
class Step:
    """Commands of one block, whether the last is left running, the lines they print, and where those are.

    `output` is the place of the lines in the page, from and to; None without any.
    """

    commands: tuple[str, ...]
    leave_running: bool
    expected: tuple[str, ...]
    output: tuple[int, int] | None = None


def steps(page: Path) -> list[Step]:
    """Return the steps of a page, in order."""
    blocks = list(_FENCE.finditer(page.read_text()))
    found: list[Step] = []
    for block, after in zip_longest(blocks, blocks[1:]):
        if block["language"] != "sh" or _NOT_TYPED_HERE.search(block["info"]):
            continue
        commands = [
            line
            for line in block["body"].replace("\\\n", " ").splitlines()
            if line and not line.startswith("#")
        ]
        expected: list[str] = []
        output = None
        if after is not None and after["language"] == "text":
            expected = [
                line
                for line in after["body"].splitlines()
                if line.strip() and not _NOT_IN_EVERY_RUN.search(line)
            ]
            if 'test="varies"' in after["info"]:
                expected = [expected[0], expected[-1]]
            output = after.span("body")
        mark = _MARK.search(block["info"])
        is_left = mark is not None and mark[1] == "leave running"
        found.append(Step(tuple(commands), is_left, tuple(expected), output))
    return found


def argv(command: str) -> list[str]:
    """Return how a command is started: its words, or a shell if it needs one."""
    return ["bash", "-c", command] if _NEEDS_SHELL.search(_QUOTED.sub("", command)) else shlex.split(command)


def programs(page: Path) -> dict[str, str]:
    """Return the programs, sketches and settings to save, by file name."""
    titled = (
        (re.search(r'title="([\w.]+\.(?:py|toml|ino|cpp|urdf|launch|yaml|json5|sh))"', match["info"]), match)
        for match in _FENCE.finditer(page.read_text())
    )
    return {title[1]: match["body"] for title, match in titled if title is not None}


def on_machines(page: Path) -> dict[str, tuple[str, ...]]:
    """Return the commands of blocks marked "on NAME...", by mark."""
    found = {}
    for match in _FENCE.finditer(page.read_text()):
        if (mark := _MARK.search(match["info"])) and mark[1].startswith("on "):
            found[mark[1]] = tuple(match["body"].splitlines())
    return found


def missing_lines(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return the expected lines that have not been printed, in order, so far."""
    position = 0
    for index, line in enumerate(expected):
        match = _line_pattern(line).search(printed, position)
        if match is None:
            return list(expected[index:])
        position = match.end()
    return []


def matching_lines(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return the whole lines in which the expected ones were printed."""
    found: list[str] = []
    position = 0
    for line in expected:
        match = _line_pattern(line).search(printed, position)
        assert match is not None
        position = match.end()
        # A number matches with the space before it, which may be the end of the line above.
        start = match.end() - len(match[0].lstrip())
        whole = printed[printed.rfind("\n", 0, start) + 1 :].partition("\n")[0].rstrip()
        if found[-1:] != [whole]:
            found.append(whole)
    return found


def lines_until(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return all lines up to the one in which the last of the expected ones was printed."""
    position = 0
    for line in expected:
        match = _line_pattern(line).search(printed, position)
        assert match is not None
        position = match.end()
    rest_of_line = printed[position:].partition("\n")[0]
    return (printed[:position] + rest_of_line).splitlines() if expected else []


def _line_pattern(line: str) -> re.Pattern[str]:
    parts, position = [], 0
    text = line.strip()
    for match in _VARYING.finditer(text):
        parts += [re.escape(text[position : match.start()]), _PATTERNS[match.lastgroup or "space"]]
        position = match.end()
    return re.compile("".join([*parts, re.escape(text[position:])]))
