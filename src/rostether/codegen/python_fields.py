"""Generates the MicroPython code that initializes, writes and reads the fields of a message.

Adjacent numbers share one call of `struct`. The code uses no built-in names, because definitions may hide
them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from struct import calcsize

from msgspec import Struct

from rostether.msgdef.spec import Field
from rostether.serde.type_tree import SCALARS, Number

_ZEROS = {"string": '""', "bool": "False", "float32": "0.0", "float64": "0.0"}
TIME_CLASSES = {"time": "_Time", "duration": "_Duration"}


class PythonField(Struct, frozen=True):
    """A field, its name in Python, and for a message also its class and smallest size."""

    field: Field
    name: str
    class_name: str = ""
    min_bytes: int = 0

    @property
    def code(self) -> str:
        """The format character of `struct`; empty for strings, times and messages."""
        scalar = SCALARS.get(self.field.type.base)
        return scalar.code if isinstance(scalar, Number) else ""

    @property
    def is_number(self) -> bool:
        """Whether it is a single number."""
        return bool(self.code) and not self.field.type.is_array

    def default(self) -> str:
        """Return the default of the constructor's argument."""
        if self.field.type.is_array or self.class_name:
            return "None"
        return _ZEROS.get(self.field.type.base, "0")

    def initial(self) -> str:
        """Return the value that the constructor uses for None."""
        kind = self.field.type
        if not kind.is_array:
            return f"{self.class_name}()"
        if self.code == "B":
            return rf'b"\0" * {kind.length}' if kind.length else 'b""'
        if not kind.length:
            return "[]"
        if self.class_name:
            return f"_repeat({self.class_name}, {kind.length})"
        return f"[{_ZEROS.get(kind.base, '0')}] * {kind.length}"

    def write_statement(self) -> str:
        """Return the statement that writes a field that is not a number."""
        kind, value = self.field.type, f"self.{self.name}"
        if not kind.is_array:
            return f"{value}.serialize(writer)" if self.class_name else f"writer.string({value})"
        length = f", {kind.length}" if kind.length is not None else ""
        if self.class_name:
            return f"writer.messages({value}{length})"
        if kind.base == "string":
            return f"writer.strings({value}{length})"
        return (
            f"writer.bytes({value}{length})"
            if self.code == "B"
            else f'writer.array("{self.code}", {value}{length})'
        )

    def read_statement(self) -> str:
        """Return the statement that reads a field that is not a number."""
        kind, value = self.field.type, f"self.{self.name}"
        if not kind.is_array:
            return f"{value}.deserialize(reader)" if self.class_name else f"{value} = reader.string()"
        length = str(kind.length) if kind.length is not None else ""
        more = f", {length}" if length else ""
        if self.class_name:
            return f"{value} = reader.messages({self.class_name}, {self.min_bytes}{more})"
        if kind.base == "string":
            return f"{value} = reader.strings({length})"
        return (
            f"{value} = reader.bytes({length})"
            if self.code == "B"
            else f'{value} = reader.array("{self.code}"{more})'
        )


def writing(fields: Sequence[PythonField]) -> Iterator[str]:
    """Yield the statements that write the fields."""
    for is_number, run in groupby(fields, lambda each: each.is_number):
        group = list(run)
        if not is_number:
            yield from (each.write_statement() for each in group)
            continue
        values = (
            f"1 if self.{each.name} else 0" if each.code == "?" else f"self.{each.name}" for each in group
        )
        yield f'_pack("{_format(group)}", writer.buffer, writer.room({_size(group)}), {", ".join(values)})'


def reading(fields: Sequence[PythonField]) -> Iterator[str]:
    """Yield the statements that read the fields."""
    for is_number, run in groupby(fields, lambda each: each.is_number):
        group = list(run)
        if not is_number:
            yield from (each.read_statement() for each in group)
            continue
        targets = ", ".join(f"self.{each.name}" for each in group) + ("," if len(group) == 1 else "")
        yield f'{targets} = _unpack("{_format(group)}", reader.buffer, reader.skip({_size(group)}))'
        yield from (f"self.{each.name} = self.{each.name} != 0" for each in group if each.code == "?")


def _format(group: Sequence[PythonField]) -> str:
    return "<" + "".join(each.code.replace("?", "B") for each in group)


def _size(group: Sequence[PythonField]) -> int:
    return calcsize(_format(group))
