"""Words that generated names must avoid, because they have a meaning in C++ or in sketches."""

from __future__ import annotations

import functools
import re
from pathlib import Path

_SHARE = Path(__file__).with_name("share")
_BINARY_LITERAL = re.compile(r"B[01]{1,8}")

LIBRARY_NAMESPACE = "ros"

MEMBERS_OF_EVERY_MESSAGE = frozenset(
    {
        *("serialize", "deserialize", "serializedLength"),
        *("getType", "getMD5", "flashNames"),
        *("_fields", "Archive", "Self"),
    }
)

TYPES_OF_FIELDS = frozenset(f"{sign}int{bits}_t" for sign in ("", "u") for bits in (8, 16, 32, 64))


def keywords() -> frozenset[str]:
    """Return the keywords and alternative tokens of C++, up to C++20."""
    return _names("keywords.txt")


def global_names() -> frozenset[str]:
    """Return functions and types of C, POSIX and Arduino, which cannot be names of namespaces."""
    return _names("global_names.txt")


def arduino_macros() -> frozenset[str]:
    """Return the macros with a value in Arduino.h, except the binary literals B0 to B11111111."""
    return _names("arduino_macros.txt")


def platform_macros() -> frozenset[str]:
    """Return more macros with a value: those of newlib, POSIX and Windows."""
    return _names("platform_macros.txt")


def is_macro(name: str) -> bool:
    """Return whether the name is a macro on any supported platform."""
    return name in arduino_macros() or name in platform_macros() or _is_binary_literal(name)


def is_macro_in_sketches(name: str) -> bool:
    """Return whether the name is a macro that sketches see, so not a lower-case macro of PCs.

    `near` is a macro on Windows, `linux` on Linux; sketches use fields with these names.
    """
    if name in arduino_macros() or _is_binary_literal(name):
        return True
    return name in platform_macros() and name.upper() == name


def _is_binary_literal(name: str) -> bool:
    return _BINARY_LITERAL.fullmatch(name) is not None


@functools.cache
def _names(file: str) -> frozenset[str]:
    return frozenset((_SHARE / file).read_text(encoding="ascii").split())
