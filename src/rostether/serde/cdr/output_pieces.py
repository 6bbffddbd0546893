"""The pieces of a converter's output, as Python expressions; adjacent pieces are joined."""

from __future__ import annotations


class OutputPieces:
    """Collects slices of the input `b`, constants and other expressions, in the order of the output."""

    def __init__(self) -> None:
        self._pieces: list[str | bytes | tuple[str, str]] = []

    def __bool__(self) -> bool:
        return bool(self._pieces)

    def add_slice(self, start: str, end: str) -> None:
        """Add the input between two positions, both as expressions."""
        last = self._pieces[-1] if self._pieces else None
        if isinstance(last, tuple) and last[1] == start:
            self._pieces[-1] = (last[0], end)
        elif start != end:
            self._pieces.append((start, end))

    def add_constant(self, value: bytes) -> None:
        """Add bytes."""
        last = self._pieces[-1] if self._pieces else None
        if isinstance(last, bytes):
            self._pieces[-1] = last + value
        elif value:
            self._pieces.append(value)

    def add_expression(self, expression: str) -> None:
        """Add the value of an expression."""
        self._pieces.append(expression)

    def remove_final_nul(self) -> bool:
        """Remove the last piece if it is a constant of one zero byte."""
        if self._pieces and self._pieces[-1] == b"\0":
            self._pieces.pop()
            return True
        return False

    def pop_all(self) -> list[str]:
        """Return all expressions, and clear them."""
        pieces, self._pieces = self._pieces, []
        return [_expression(piece) for piece in pieces]


def _expression(piece: str | bytes | tuple[str, str]) -> str:
    if isinstance(piece, tuple):
        return f"b[{piece[0]}:{piece[1]}]"
    return piece if isinstance(piece, str) else repr(piece)
