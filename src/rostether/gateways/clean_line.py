"""What clients sent, as a line of a log."""

from __future__ import annotations


def clean_line(text: str) -> str:
    """Return a text that holds what a client sent as one line that any terminal and any encoding takes."""
    line = " ".join(text.split())
    return line if line.isprintable() else "".join(c if c.isprintable() else "\ufffd" for c in line)
