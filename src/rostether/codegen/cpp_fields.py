"""The lines that one field contributes to its message's class."""

from __future__ import annotations

from dataclasses import dataclass

from rostether.codegen.cpp_names import is_variable_array
from rostether.codegen.cpp_types import (
    element_type,
    is_message,
    scalar_type,
    sequence_element_type,
    zero,
)
from rostether.msgdef.spec import Field

# float64[] has a special pointer class: sketches assign arrays of float and of double.
_SEQUENCE_POINTERS = {"float64": "ros::Float64Pointer"}
# Elements of eight bytes are not aligned in the receive buffer as their type would have it.
_SEQUENCES_OF_64_BITS = frozenset({"int64", "uint64"})


@dataclass(frozen=True, slots=True)
class FieldLines:
    """Declarations, initializers (`name{value}`) and the call that gives the field to an archive."""

    declarations: tuple[str, ...]
    initializers: tuple[str, ...]
    archive_call: str


def field_lines(field: Field, name: str) -> FieldLines:
    """Return the lines of a field whose member is called `name`."""
    if is_variable_array(field):
        return _sequence(field, name)
    if field.type.is_array:
        return _fixed_array(field, name)
    return _single_value(field, name)


def _single_value(field: Field, name: str) -> FieldLines:
    base = field.type.base
    call = "message" if is_message(base) else "string" if base == "string" else "value"
    return FieldLines(
        (f"typedef {scalar_type(base)} _{name}_type;", f"_{name}_type {name};"),
        (f"{name}{{{zero(base)}}}",),
        f"archive.{call}(self.{name});",
    )


def _fixed_array(field: Field, name: str) -> FieldLines:
    if field.type.length == 0:
        # C++ has no arrays without elements, and there is nothing to send.
        return FieldLines((f"// {name} has no elements.",), (), "")
    return FieldLines(
        (f"{element_type(field.type.base)} {name}[{field.type.length}];",),
        (f"{name}{{}}",),
        f"archive.fixed(self.{name});",
    )


def _sequence(field: Field, name: str) -> FieldLines:
    base = field.type.base
    pointer = _SEQUENCE_POINTERS.get(base, f"_{name}_type*")
    call = "sequence64" if base in _SEQUENCES_OF_64_BITS else "sequence"
    return FieldLines(
        (
            f"ros::array_length {name}_length;",
            f"typedef {sequence_element_type(base)} _{name}_type;",
            f"{pointer} {name};",
        ),
        (f"{name}_length{{0}}", f"{name}{{nullptr}}"),
        f"archive.{call}(self.{name}, self.{name}_length);",
    )
