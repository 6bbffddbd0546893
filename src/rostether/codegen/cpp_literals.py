"""C++ literals for constants: the same value on every board, without compiler warnings."""

from __future__ import annotations

import math

_INT16_MAX = (1 << 15) - 1
_INT32_MAX = (1 << 31) - 1
_UINT32_MAX = (1 << 32) - 1
_INT64_MAX = (1 << 63) - 1
# The range of AVR's four-byte double; its compiler warns about literals outside this range.
_FLOAT_MAX = float.fromhex("0x1.fffffep+127")
_FLOAT_MIN = float.fromhex("0x1p-149")
# From these values on, rounding to a float gives infinity or zero.
_FLOAT_OVERFLOW = float.fromhex("0x1.ffffffp+127")
_FLOAT_UNDERFLOW = float.fromhex("0x1p-150")
_SHORT_ESCAPES = {"\n": "\\n", "\t": "\\t", '"': '\\"', "\\": "\\\\"}


def integer_literal(value: int) -> str:
    """Return an integer with the suffix that boards with a 16-bit int need."""
    if value < 0:
        # C++ has no negative literals, so the smallest value of a type is written as -MAX - 1.
        if -value - 1 in (_INT32_MAX, _INT64_MAX):
            return f"(-{_signed_literal(-value - 1)} - 1)"
        return f"-{_signed_literal(-value)}"
    if _INT32_MAX < value <= _UINT32_MAX:
        return f"{value}UL"
    return _signed_literal(value) if value <= _INT64_MAX else f"{value}ULL"


def _signed_literal(value: int) -> str:
    if value <= _INT16_MAX:
        return str(value)
    return f"{value}L" if value <= _INT32_MAX else f"{value}LL"


def float32_literal(value: float) -> str:
    """Return a float literal; a value outside the range of float becomes infinite or zero."""
    if abs(value) >= _FLOAT_OVERFLOW:
        value = math.copysign(math.inf, value)
    elif abs(value) < _FLOAT_MIN:
        value = math.copysign(_FLOAT_MIN if abs(value) > _FLOAT_UNDERFLOW else 0.0, value)
    return _literal(value, "f")


def float64_literal(value: float) -> str:
    """Return a double literal."""
    return _literal(value, "")


def narrow_double_literal(value: float) -> str | None:
    """Return the double literal for boards with a four-byte double, None if `float64_literal` fits them."""
    if value == 0 or not math.isfinite(value) or _FLOAT_MIN <= abs(value) <= _FLOAT_MAX:
        return None
    return float32_literal(value).removesuffix("f")


def string_literal(text: str) -> str:
    """Return a string literal in ASCII; other characters are escaped as UTF-8 bytes."""
    return '"' + "".join(map(_escape, text)) + '"'


def _literal(value: float, suffix: str) -> str:
    if math.isnan(value):
        return f'__builtin_nan{suffix}("")'
    if math.isinf(value):
        return f"{'-' if value < 0 else ''}__builtin_inf{suffix}()"
    return repr(value) + suffix


def _escape(character: str) -> str:
    if character in _SHORT_ESCAPES:
        return _SHORT_ESCAPES[character]
    # A question mark may begin a trigraph.
    if " " <= character <= "~" and character != "?":
        return character
    # Always three digits, so that a digit after them is not part of the escape.
    return "".join(f"\\{byte:03o}" for byte in character.encode("utf-8", "surrogateescape"))
