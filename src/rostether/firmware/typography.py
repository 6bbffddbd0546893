"""Typographic characters from web pages and PDFs, which compilers do not accept."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass

from rostether.firmware.cpp_tokens import tokenize

# More errors of this kind do not help: all of them come from the same pasted page.
MAX_REPORTED = 8

_PLAIN = {
    **dict.fromkeys("\u201c\u201d\u201e\u201f\u00ab\u00bb\u2033", '"'),
    **dict.fromkeys("\u2018\u2019\u201a\u201b\u2032\u00b4", "'"),
    **dict.fromkeys("\u2010\u2011\u2012\u2013\u2014\u2212", "-"),
    **dict.fromkeys("\u00a0\u2002\u2003\u2007\u2009\u200a\u202f\u3000", "a space"),
    **dict.fromkeys("\u200b\u200c\u200d\u2060\ufeff\u00ad", "nothing"),
    "\u2026": "...",
    "\uff1b": ";",
    "\u037e": ";",
    "\u2217": "*",
    "\u00d7": "*",
    "\u2039": "<",
    "\u203a": ">",
}


@dataclass(frozen=True, slots=True)
class Typographic:
    """A wrong character in code, and its replacement; line and column count from 1."""

    line: int
    column: int
    character: str
    plain: str

    def explain(self, path: str) -> str:
        """Return an error in the compiler's format, with the character to type."""
        name = unicodedata.name(self.character, "").lower() or f"character U+{ord(self.character):04X}"
        shown = f"{self.character} " if self.character.isprintable() and not self.character.isspace() else ""
        return (
            f"{path}:{self.line}:{self.column}: error: {shown}({name}) comes from a web page or PDF; "
            f"type {self.plain} instead"
        )


def find_typographic(text: str) -> list[Typographic]:
    """Return the first typographic characters outside comments and complete strings."""
    found: list[Typographic] = []
    for token in tokenize(text):
        if token.kind == "comment" or (token.kind in ("string", "char") and _is_complete(token.text)):
            continue
        for index, character in enumerate(token.text):
            if character in _PLAIN and len(found) < MAX_REPORTED:
                offset = token.offset + index
                line_start = text.rfind("\n", 0, offset) + 1
                found.append(
                    Typographic(
                        text.count("\n", 0, offset) + 1, offset - line_start + 1, character, _PLAIN[character]
                    )
                )
    return found


def _is_complete(text: str) -> bool:
    return len(text) > 1 and text[-1] == text[text.find(text[-1])] and text.find(text[-1]) != len(text) - 1
