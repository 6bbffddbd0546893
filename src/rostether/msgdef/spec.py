"""The content of a .msg or .srv text, as values: fields, constants, messages and services.

Type names are `package/Name`, as in ROS 1.
"""

from __future__ import annotations

from typing import TypeAlias

from msgspec import Struct

ConstantValue: TypeAlias = bool | int | float | str


class FieldType(Struct, frozen=True):
    """The type of one field.

    `base` is a primitive name (`int32`, `string`, `time` ...) or a full `package/Name`.
    `length` is None for a variable-length array and meaningless unless `is_array`. `length_text` is the
    length as written (`05`), which is part of the md5sum's input.
    """

    base: str
    is_array: bool = False
    length: int | None = None
    length_text: str = ""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FieldType) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[str, bool, int | None]:
        return self.base, self.is_array, self.length

    def __str__(self) -> str:
        if not self.is_array:
            return self.base
        return f"{self.base}[{'' if self.length is None else self.length_text or self.length}]"


class Field(Struct, frozen=True):
    """One field of a message, service request or response."""

    type: FieldType
    name: str


class Constant(Struct, frozen=True):
    """One constant; `text` is its value as written (for the md5sum), `value` the parsed one."""

    type: str
    name: str
    value: ConstantValue
    text: str


class _Definition(Struct, frozen=True):
    package: str
    name: str

    @property
    def full_name(self) -> str:
        """The name `package/Name`."""
        return f"{self.package}/{self.name}"


class MessageSpec(_Definition, frozen=True):
    """One message definition; `text` is its source as read."""

    fields: tuple[Field, ...]
    constants: tuple[Constant, ...]
    text: str


class ServiceSpec(_Definition, frozen=True):
    """One service definition; its messages are named `NameRequest` and `NameResponse`."""

    request: MessageSpec
    response: MessageSpec
    text: str
