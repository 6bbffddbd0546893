"""keywords.txt, by which the Arduino IDE colours the library's words and the classes of messages."""

from __future__ import annotations

from collections.abc import Iterable


def with_classes(library_keywords: str, classes: Iterable[str]) -> str:
    """Return the library's keywords.txt with further classes, each word once."""
    lines = library_keywords.rstrip("\n").splitlines()
    known = {line.partition("\t")[0] for line in lines}
    lines.extend(f"{name}\tKEYWORD1" for name in sorted(set(classes) - known))
    return "\n".join(lines) + "\n"
