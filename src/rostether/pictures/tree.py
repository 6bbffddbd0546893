"""The lines of a tree in a terminal, each entry below its parent."""

from __future__ import annotations

# Ten times the levels of real robots. Without a limit, the text of a chain grows as the square of its length.
MAX_INDENTED = 100


def branch(indent: str, *, is_last: bool) -> tuple[str, str]:
    """Return the text before an entry's name, and the indent of the entries below it.

    `indent` is that of the entry and its siblings, empty below the root; `is_last`: no sibling follows.
    Levels deeper than `MAX_INDENTED` are not indented further.
    """
    below = indent + ("   " if is_last else "│  ")
    return indent + ("└─ " if is_last else "├─ "), below[: 3 * MAX_INDENTED]
