"""The built-in types of ROS 1 definitions."""

from __future__ import annotations

from types import MappingProxyType

INTEGER_RANGES = MappingProxyType(
    {
        "int8": (-(1 << 7), (1 << 7) - 1),
        "uint8": (0, (1 << 8) - 1),
        "int16": (-(1 << 15), (1 << 15) - 1),
        "uint16": (0, (1 << 16) - 1),
        "int32": (-(1 << 31), (1 << 31) - 1),
        "uint32": (0, (1 << 32) - 1),
        "int64": (-(1 << 63), (1 << 63) - 1),
        "uint64": (0, (1 << 64) - 1),
        # The two old names: byte is signed, char is not, unlike in C.
        "byte": (-(1 << 7), (1 << 7) - 1),
        "char": (0, (1 << 8) - 1),
    }
)
CONSTANT_TYPES = frozenset(INTEGER_RANGES) | {"float32", "float64", "string", "bool"}
PRIMITIVE_TYPES = CONSTANT_TYPES | {"time", "duration"}
