"""The commands of a documentation page, and the output that the page shows.

Blocks in `sh` have commands, one per line; `\\` continues a line. A `text` block after them has lines that
the last command prints, in this order. Numbers and times may differ, and lines that not every run prints are
not required. The attribute `test` of a block is for the tests; the build of the pages removes it:

- on commands, "leave running" leaves the last one running, "not run" means that they need a board, and
  "on NAME" that they need a machine of that name;
- on output, "varies" means that each run prints different lines between the first and the last.

A title that is a file name means that the reader saves the block as this file.
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
# Syntax that needs a shell.
_NEEDS_SHELL = re.compile(r"[\"'$`\\\\~*?\[\]{}()<>|&;#]|^\w+=|^cd ")
_SKIPPED_BLOCK = re.compile(r'test="not run|test="on |title="[\w.]+\.sh"')

# Differs from run to run: bars, hexadecimal numbers with a digit, numbers, and widths of columns.
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
# Printed only on the first run, by commands that wait for others, or if the demo's board is a simulated Uno.
_NOT_IN_EVERY_RUN = re.compile(
    r"preparing a simulated |Building the sketch for |waiting: |not registered as \S+ yet: "
    r"|/virtual_board_simulation/"
)


@dataclass(frozen=True, slots=True)
class Step:
    """The commands of one block, whether the last one is left running, and the lines that they print.

    `output` is the range of these lines in the page, or None without output.
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
        if block["language"] != "sh" or _SKIPPED_BLOCK.search(block["info"]):
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
        leaves_running = mark is not None and mark[1] == "leave running"
        found.append(Step(tuple(commands), leaves_running, tuple(expected), output))
    return found


def argv(command: str) -> list[str]:
    """Return the arguments that start a command; with a shell, if it needs one."""
    return ["bash", "-c", command] if _NEEDS_SHELL.search(_QUOTED.sub("", command)) else shlex.split(command)


def programs(page: Path) -> dict[str, str]:
    """Return the files that the page says to save (programs, sketches, settings), by name."""
    titled = (
        (re.search(r'title="([\w.]+\.(?:py|toml|ino|cpp|urdf|launch|yaml|json5|sh))"', match["info"]), match)
        for match in _FENCE.finditer(page.read_text())
    )
    return {title[1]: match["body"] for title, match in titled if title is not None}


def commands_on_machines(page: Path) -> dict[str, tuple[str, ...]]:
    """Return the commands of blocks marked "on NAME...", by mark."""
    found = {}
    for match in _FENCE.finditer(page.read_text()):
        if (mark := _MARK.search(match["info"])) and mark[1].startswith("on "):
            found[mark[1]] = tuple(match["body"].splitlines())
    return found


def missing_lines(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return the expected lines that were not printed yet, in order."""
    position = 0
    for index, line in enumerate(expected):
        match = _line_pattern(line).search(printed, position)
        if match is None:
            return list(expected[index:])
        position = match.end()
    return []


def matching_lines(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return the printed lines that contain the expected ones."""
    found: list[str] = []
    position = 0
    for line in expected:
        match = _line_pattern(line).search(printed, position)
        assert match is not None
        position = match.end()
        # A number matches with the space before it, which may include the end of the previous line.
        start = match.end() - len(match[0].lstrip())
        whole = printed[printed.rfind("\n", 0, start) + 1 :].partition("\n")[0].rstrip()
        if found[-1:] != [whole]:
            found.append(whole)
    return found


def lines_until(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return all lines up to the one that contains the last expected line."""
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
