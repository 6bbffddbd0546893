"""Pieces of generated Python source for encoders and decoders.

The only text from a definition in generated source is a field's name, which `MessageClasses.of` has checked.
"""

from __future__ import annotations

from keyword import iskeyword


def attribute(variable: str, field: str) -> str:
    """Return the expression of a field; `from`, `lambda` and `pass` are fields in real messages."""
    return f"getattr({variable}, {field!r})" if iskeyword(field) else f"{variable}.{field}"


def attribute_store(variable: str, field: str, value: str) -> str:
    """Return the statement that sets a field."""
    return f"setattr({variable}, {field!r}, {value})" if iskeyword(field) else f"{variable}.{field} = {value}"


def indented(lines: list[str], columns: int) -> list[str]:
    """Return the lines moved to the right."""
    return [" " * columns + line for line in lines]
