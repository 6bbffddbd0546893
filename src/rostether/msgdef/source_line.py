"""A line of a definition's text, for errors that show where they are."""

from __future__ import annotations

from typing import NoReturn

from msgspec import Struct

from rostether.errors import DefinitionError


class SourceLine(Struct, frozen=True):
    """One line of a file; `declaration` is its part before a comment."""

    file: str
    number: int
    text: str
    declaration: str

    def fail(self, message: str, token: str = "") -> NoReturn:
        """Raise DefinitionError for the last occurrence of a token, or for the whole line."""
        position = self.declaration.rfind(token) if token else -1
        if position < 0:
            position = len(self.text) - len(self.text.lstrip())
        raise DefinitionError(message, file=self.file, line=self.number, column=position + 1)
