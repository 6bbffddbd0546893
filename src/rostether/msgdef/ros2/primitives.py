"""The built-in types of ROS 2 definitions."""

from __future__ import annotations

from types import MappingProxyType

from rostether.msgdef import primitives as ros1_primitives

STRING_TYPES = frozenset({"string", "wstring"})
INTEGER_RANGES = MappingProxyType(
    # Both old names are unsigned in ROS 2: byte is an octet, char a uint8.
    {**ros1_primitives.INTEGER_RANGES, "byte": (0, (1 << 8) - 1), "char": (0, (1 << 8) - 1)}
)
PRIMITIVE_TYPES = frozenset(INTEGER_RANGES) | STRING_TYPES | {"bool", "float32", "float64"}
