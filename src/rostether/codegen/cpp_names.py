"""The C++ names of packages, messages, fields and constants: those of the definition if possible.

A name that is reserved in C++, is a macro, or belongs to another member gets a trailing underscore.
"""

from __future__ import annotations

from msgspec import Struct

from rostether.codegen.reserved_words import (
    LIBRARY_NAMESPACE,
    MEMBERS_OF_EVERY_MESSAGE,
    TYPES_OF_FIELDS,
    global_names,
    is_macro,
    is_macro_in_sketches,
    keywords,
)
from rostether.msgdef.spec import Constant, Field, MessageSpec


class NamedConstant(Struct, frozen=True):
    """A constant and its name in sketches; `alias` is a second name if the first may be a macro."""

    constant: Constant
    name: str
    alias: str | None = None


class MemberNames(Struct, frozen=True):
    """The names of a message's fields in the order of its definition, and its constants."""

    fields: tuple[str, ...]
    constants: tuple[NamedConstant, ...]


def namespace_name(package: str) -> str:
    """Return the namespace of a package; ROS also allows dashes in package names."""
    name = package.replace("-", "_")
    return f"{name}_" if name in keywords() or name in global_names() or is_macro(name) else name


def class_name(short_name: str) -> str:
    """Return the class of a message or service, without its namespace."""
    taken = short_name in keywords() or short_name == LIBRARY_NAMESPACE or is_macro(short_name)
    return f"{short_name}_" if taken else short_name


def qualified_class(full_name: str) -> str:
    """Return the class of `package/Name` with its namespace, valid in every header."""
    package, _, short_name = full_name.partition("/")
    # With a leading `::`, because a package may have a message with the name of another package.
    return f"::{namespace_name(package)}::{class_name(short_name)}"


def constants_class(cpp_class: str) -> str:
    """Return the name of the class with the float and string constants of a message's class."""
    # The name of a message cannot begin with an underscore.
    return f"_constants_of_{cpp_class}"


def include_path(full_name: str) -> str:
    """Return the header that sketches include for `package/Name`."""
    return f"{full_name}.h"


def include_guard(full_name: str) -> str:
    """Return the macro that guards a header. No two types share one, even if they differ only in case."""
    package, _, short_name = full_name.partition("/")
    # Distinguishes a_b/C from a/b_C.
    length = f"_{len(package)}" if "_" in short_name else ""
    return f"ROS_{package.replace('-', '__')}_{short_name}{length}_H_"


def name_members(spec: MessageSpec) -> MemberNames:
    """Choose the names of all members of a message. Fields have priority: sketches use them most."""
    taken = {class_name(spec.name), *MEMBERS_OF_EVERY_MESSAGE, *TYPES_OF_FIELDS}
    fields = _name_fields(spec.fields, taken)
    taken.update(f"_{name}_type" for name in fields)
    # If a constant is declared twice, the last value is used, as in Python.
    constants = {constant.name: constant for constant in spec.constants}
    return MemberNames(fields, tuple(_name_constant(constant, taken) for constant in constants.values()))


def _name_fields(fields: tuple[Field, ...], taken: set[str]) -> tuple[str, ...]:
    # The length of an array is also a member.
    lengths = {f"{field.name}_length" for field in fields if is_variable_array(field)}
    free = {field.name for field in fields if not (_is_unusable(field.name) or field.name in taken | lengths)}
    taken |= free | lengths
    return tuple(each.name if each.name in free else _new_name(each, taken) for each in fields)


def _new_name(field: Field, taken: set[str]) -> str:
    name = _first_free(field.name, taken)
    while is_variable_array(field) and f"{name}_length" in taken:
        name = _first_free(name, taken)
    taken.update({f"{name}_length"} if is_variable_array(field) else ())
    return name


def is_variable_array(field: Field) -> bool:
    """Return whether the field is an array whose length is in each message."""
    return field.type.is_array and field.type.length is None


def _name_constant(constant: Constant, taken: set[str]) -> NamedConstant:
    name = constant.name
    if name in keywords() or name in taken:
        return NamedConstant(constant, _first_free(name, taken))
    taken.add(name)
    return NamedConstant(constant, name, _first_free(name, taken) if is_macro(name) else None)


def _is_unusable(name: str) -> bool:
    return name in keywords() or is_macro_in_sketches(name)


def _first_free(name: str, taken: set[str]) -> str:
    candidate = f"{name}_"
    while candidate in taken or _is_unusable(candidate):
        candidate += "_"
    taken.add(candidate)
    return candidate
