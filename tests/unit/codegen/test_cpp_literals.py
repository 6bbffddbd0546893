from __future__ import annotations

import math
import struct

import pytest

from rostether.codegen.cpp_literals import (
    float32_literal,
    float64_literal,
    integer_literal,
    narrow_double_literal,
    string_literal,
)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (-1, "-1"),
        (32767, "32767"),
        (32768, "32768L"),
        (-32768, "-32768L"),
        (2147483647, "2147483647L"),
        (2147483648, "2147483648UL"),
        (4294967295, "4294967295UL"),
        (4294967296, "4294967296LL"),
        (-2147483648, "(-2147483647L - 1)"),
        (-2147483649, "-2147483649LL"),
        (-(1 << 63), "(-9223372036854775807LL - 1)"),
        ((1 << 63) - 1, "9223372036854775807LL"),
        (1 << 63, "9223372036854775808ULL"),
        ((1 << 64) - 1, "18446744073709551615ULL"),
    ],
)
def test_integers_have_the_suffix_that_16_bits_need(value: int, text: str) -> None:
    assert integer_literal(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.5, "1.5f"),
        (-0.0, "-0.0f"),
        (5.0, "5.0f"),
        (3.4028234663852886e38, "3.4028234663852886e+38f"),
        (1e300, "__builtin_inff()"),
        (-1e300, "-__builtin_inff()"),
        (1e-300, "0.0f"),
        (-1e-300, "-0.0f"),
        (1e-45, "1.401298464324817e-45f"),
        (math.nan, '__builtin_nanf("")'),
    ],
)
def test_floats_become_infinite_or_zero_where_conversion_makes_them(value: float, text: str) -> None:
    assert float32_literal(value) == text
    if text[-2].isdigit():
        assert struct.pack("<f", value) == struct.pack("<f", float(text[:-1]))


def test_doubles() -> None:
    assert float64_literal(1e300) == "1e+300"
    assert float64_literal(5e-324) == "5e-324"
    assert float64_literal(-math.inf) == "-__builtin_inf()"
    assert float64_literal(math.nan) == '__builtin_nan("")'


def test_doubles_of_four_bytes_differ_only_if_necessary() -> None:
    assert narrow_double_literal(1e300) == "__builtin_inff()"
    assert narrow_double_literal(-1e-300) == "-0.0"
    for value in (0.0, -0.0, 0.1, 1e38, 1e-40, math.inf, math.nan):
        assert narrow_double_literal(value) is None


@pytest.mark.parametrize(
    ("text", "literal"),
    [
        ("", '""'),
        ("plain # text", '"plain # text"'),
        ('"quoted"', '"\\"quoted\\""'),
        ("back\\slash", '"back\\\\slash"'),
        ("tab\t", '"tab\\t"'),
        ("what??/", '"what\\077\\077/"'),
        ("\x011", '"\\0011"'),
        ("é", '"\\303\\251"'),
        ("\x7f", '"\\177"'),
    ],
)
def test_strings_are_plain_ascii(text: str, literal: str) -> None:
    assert string_literal(text) == literal
