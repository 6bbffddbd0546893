"""The lines of a tree in a terminal, each entry below its parent."""

from __future__ import annotations

# Ten times the levels of real robots. Without a limit, the text of a chain grows as the square of its length.
MAX_INDENTED = 100


def branch(lead: str, *, is_last: bool) -> tuple[str, str]:
    """Return the text before a child's name, and the lead of the child's own children.

    Levels deeper than `MAX_INDENTED` are not indented further.

    Args:
        lead: The lead of its parent's children; empty at the root.
        is_last: Whether no sibling follows.
    """
    below = lead + ("   " if is_last else "│  ")
    return lead + ("└─ " if is_last else "├─ "), below[: 3 * MAX_INDENTED]
