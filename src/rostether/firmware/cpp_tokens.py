"""Splits C++ code into tokens: enough of the language to find declarations, even in invalid code."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Literal

from msgspec import Struct

TokenKind = Literal["name", "number", "string", "char", "punctuation", "directive", "comment"]

_TOKEN = re.compile(
    r"""
      (?P<space>\s+)
    | (?P<comment> // (?: \\\n | [^\n] )* | /\* .*? (?: \*/ | \Z ) )
    | (?P<raw> (?: u8 | [uUL] )? R" (?P<mark> [^()\\\s]{0,16} ) \( .*? (?: \) (?P=mark) " | \Z ) )
    | (?P<string> (?: u8 | [uUL] )? " (?: \\. | [^"\\\n] )* (?: " | (?=\n) | \Z ) )
    | (?P<char> [uUL]? ' (?: \\. | [^'\\\n] )* (?: ' | (?=\n) | \Z ) )
    | (?P<number> \.? \d (?: [eEpP][+-] | [\w.] )* )
    | (?P<name> [A-Za-z_$] [\w$]* )
    | (?P<directive> \# (?: \\\n | /\* .*? \*/ | " (?: \\. | [^"\\\n] )* " | // [^\n]* | [^\n] )* )
    | (?P<punctuation> :: | -> | && | \[\[ | \]\] | [=!<>+\-*/%&|^]= | . )
    """,
    re.VERBOSE | re.DOTALL | re.ASCII,
)
_KINDS: dict[str, TokenKind] = {"raw": "string"}


class Token(Struct, frozen=True):
    """A piece of text and its start offset."""

    kind: TokenKind
    text: str
    offset: int

    @property
    def end(self) -> int:
        """The offset after it."""
        return self.offset + len(self.text)


def tokenize(text: str) -> Iterator[Token]:
    """Yield all tokens but white space. Never fails: unknown characters are punctuation."""
    for match in _TOKEN.finditer(text):
        group = match.lastgroup or "punctuation"
        if group != "space":
            yield Token(_KINDS.get(group, group), match[0], match.start())  # type: ignore[arg-type]


def code_tokens(text: str) -> list[Token]:
    """Return the tokens without comments."""
    return [token for token in tokenize(text) if token.kind != "comment"]
