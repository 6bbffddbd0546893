"""Text from clients as one line of a log."""

from __future__ import annotations


def clean_line(text: str) -> str:
    """Return a client's text as one line that is safe for any terminal and encoding."""
    line = " ".join(text.split())
    return line if line.isprintable() else "".join(c if c.isprintable() else "\ufffd" for c in line)
