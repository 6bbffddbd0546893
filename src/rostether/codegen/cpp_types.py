"""How the types of fields are written in C++."""

from __future__ import annotations

from rostether.codegen.cpp_names import qualified_class
from rostether.msgdef.primitives import PRIMITIVE_TYPES

_PRIMITIVES = {
    "bool": "bool",
    # The two old names: byte is signed, char is not (whatever C says).
    "byte": "int8_t",
    "char": "uint8_t",
    **{f"{sign}int{bits}": f"{sign}int{bits}_t" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    "float32": "float",
    "float64": "double",
    "time": "ros::Time",
    "duration": "ros::Duration",
}
_ELEMENTS = {"string": "char*"}
_ELEMENTS_OF_SEQUENCES = {"int64": "ros::unaligned_int64", "uint64": "ros::unaligned_uint64"}
_ZEROS = {"bool": "false", "string": '""', "time": "", "duration": ""}


def is_message(base: str) -> bool:
    """Return whether a field's type is a message, not a primitive."""
    return base not in PRIMITIVE_TYPES


def scalar_type(base: str) -> str:
    """Return the type of a single value."""
    return "const char*" if base == "string" else _PRIMITIVES.get(base) or qualified_class(base)


def element_type(base: str) -> str:
    """Return the type of an element of an array of fixed length."""
    return _ELEMENTS.get(base) or scalar_type(base)


def sequence_element_type(base: str) -> str:
    """Return the type of an element of an array of variable length, which lies where it was received."""
    return _ELEMENTS_OF_SEQUENCES.get(base) or element_type(base)


def zero(base: str) -> str:
    """Return what a single value is initialized with, between braces."""
    return "" if is_message(base) else _ZEROS.get(base, "0")
