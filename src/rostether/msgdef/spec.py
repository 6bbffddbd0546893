"""The content of a .msg or .srv text, as values: fields, constants, messages and services.

Type names are `package/Name`, as in ROS 1.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

ConstantValue: TypeAlias = bool | int | float | str


@dataclass(frozen=True, slots=True)
class FieldType:
    """The type of one field.

    `base` is a primitive name (`int32`, `string`, `time` ...) or a full `package/Name`.
    `length` is None for a variable-length array and meaningless unless `is_array`. `length_text` is the
    length as written (`05`), which is part of the md5sum's input.
    """

    base: str
    is_array: bool = False
    length: int | None = None
    length_text: str = field(default="", compare=False)

    def __str__(self) -> str:
        if not self.is_array:
            return self.base
        return f"{self.base}[{'' if self.length is None else self.length_text or self.length}]"


@dataclass(frozen=True, slots=True)
class Field:
    """One named field."""

    type: FieldType
    name: str


@dataclass(frozen=True, slots=True)
class Constant:
    """One constant; `text` is its value as written (for the md5sum), `value` the parsed one."""

    type: str
    name: str
    value: ConstantValue
    text: str


@dataclass(frozen=True, slots=True)
class MessageSpec:
    """One message definition; `text` is its source as read."""

    package: str
    name: str
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...]
    text: str

    @property
    def full_name(self) -> str:
        """The name `package/Name`."""
        return f"{self.package}/{self.name}"


@dataclass(frozen=True, slots=True)
class ServiceSpec:
    """One service definition; its messages are named `NameRequest` and `NameResponse`."""

    package: str
    name: str
    request: MessageSpec
    response: MessageSpec
    text: str

    @property
    def full_name(self) -> str:
        """The name `package/Name`."""
        return f"{self.package}/{self.name}"
