"""A documentation page as its reader sees it: which commands it tells to type, and what they should print.

Fenced blocks count when their language is `sh` (commands, one a line, `\\` continues), followed or not by a
`text` block (lines that must appear in that order; `...` stands for anything). A title that begins with
"Terminal 1" means that the last command is left running, as the reader would leave it; the title
"not run" marks commands that need a board, "on NAME" those that need a machine of that name, and titles that
are names of files mark what the reader is to save.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_FENCE = re.compile(r"^```(?P<language>\w+)(?P<info>[^\n]*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)


_NOT_TYPED_HERE = re.compile(r'not run|title="on |title="[\w.]+\.sh"')


@dataclass(frozen=True, slots=True)
class Step:
    """Commands of one block, whether the last is left running, and the lines they should print."""

    commands: tuple[str, ...]
    leave_running: bool
    expected: tuple[str, ...]


def steps(page: Path) -> list[Step]:
    """Return the steps of a page, in order."""
    blocks = [
        (match["language"], match["info"], match["body"]) for match in _FENCE.finditer(page.read_text())
    ]
    found: list[Step] = []
    for index, (language, info, body) in enumerate(blocks):
        if language != "sh" or _NOT_TYPED_HERE.search(info):
            continue
        commands = [
            line for line in body.replace("\\\n", " ").splitlines() if line and not line.startswith("#")
        ]
        expected: list[str] = []
        if index + 1 < len(blocks) and blocks[index + 1][0] == "text":
            expected = [line for line in blocks[index + 1][2].splitlines() if line.strip() not in ("", "...")]
        found.append(Step(tuple(commands), "Terminal 1" in info, tuple(expected)))
    return found


def programs(page: Path) -> dict[str, str]:
    """Return the programs, sketches and settings that the page tells to save, by file name."""
    titled = (
        (re.search(r'title="([\w.]+\.(?:py|ino|urdf|launch|yaml|json5|sh))"', match["info"]), match)
        for match in _FENCE.finditer(page.read_text())
    )
    return {title[1]: match["body"] for title, match in titled if title is not None}


def on_machines(page: Path) -> dict[str, tuple[str, ...]]:
    """Return the commands of blocks titled "on NAME...", by title."""
    found = {}
    for match in _FENCE.finditer(page.read_text()):
        if title := re.search(r'title="(on [^"]+)"', match["info"]):
            found[title[1]] = tuple(match["body"].splitlines())
    return found


def missing_lines(expected: tuple[str, ...], printed: str) -> list[str]:
    """Return the expected lines that have not been printed, in order, so far."""
    position = 0
    for index, line in enumerate(expected):
        pattern = ".*?".join(re.escape(part) for part in line.strip().split("..."))
        match = re.compile(pattern).search(printed, position)
        if match is None:
            return list(expected[index:])
        position = match.end()
    return []
