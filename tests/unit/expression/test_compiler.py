from __future__ import annotations

import pytest

from rostether.errors import ConfigError
from rostether.expression.compiler import MAX_EXPRESSION_CHARS, compile_filter
from rostether.rostime import Time


class Header:
    __slots__ = ("frame_id", "stamp")

    def __init__(self) -> None:
        self.stamp = Time(12, 500_000_000)
        self.frame_id = "sonar"


class Range:
    __slots__ = ("data", "header", "range", "ranges")

    def __init__(self) -> None:
        self.header = Header()
        self.range = 0.25
        self.ranges = [1.0, 2.0, 3.0]
        self.data = b"\x01\x02"


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("m.range < 0.5", True),
        ("m.range in (0.25, 1)", True),
        ("{'sonar': m.range}['sonar'] == 0.25", True),
        ("'-'.join([m.header.frame_id, 'x']).replace('x', 'y') == 'sonar-y'", True),
        ("len(2 * m.ranges) == 6", True),
        ("m.range >= 0.5", False),
        ("0.2 < m.range < 0.3", True),
        ("m.header.frame_id == 'sonar'", True),
        ("m.header.frame_id.startswith('so')", True),
        ("m.header.stamp.secs == 12 and m.header.stamp.nsecs > 0", True),
        ("m.header.stamp.to_sec() == 12.5", True),
        ("m.header.stamp.to_nsec() == 12500000000", True),
        ("m.ranges[1] == 2.0 and m.ranges[-1] == 3.0", True),
        ("len(m.ranges[1:]) == 2", True),
        ("any(r > 2.5 for r in m.ranges)", True),
        ("sum([r for r in m.ranges if r < 3]) == 3", True),
        ("m.data[0] == 1 and m.data[1] & 2", True),
        ("m.range in (0.25, 0.5)", True),
        ("not m.range", False),
        ("m.range > math.pi", False),
        ("topic == '/sonar'", True),
        ("1 if m.range > 1 else 0", False),
        ("abs(-m.range) == 0.25 or unknown_is_not_reached", None),
    ],
)
def test_expressions_have_the_value_of_python(expression: str, expected: bool | None) -> None:
    if expected is None:
        with pytest.raises(ConfigError, match="unknown_is_not_reached"):
            compile_filter(expression)
    else:
        assert compile_filter(expression)(Range(), "/sonar") is expected


@pytest.mark.parametrize(
    "expression",
    [
        "__import__('os').system('true')",
        "m.__class__",
        "(lambda: 1)()",
        "open('/etc/passwd')",
        "m.header.frame_id.format(m)",
        "math.__dict__",
        "[x for x in y]",
        "(x := 1)",
        "f'{m.range}'",
        "m.range <",
        "'a' * 10**10 == ''",
        "10**10 * [1] == 1",
        "{**m.ranges}",
        "",
        "(" * 500,
        "1" * (MAX_EXPRESSION_CHARS + 1),
    ],
)
def test_other_expressions_are_refused_in_one_line(expression: str) -> None:
    with pytest.raises(ConfigError) as caught:
        compile_filter(expression)(Range(), "/sonar")
    assert "\n" not in str(caught.value)


def test_an_error_about_a_field_lists_the_fields() -> None:
    with pytest.raises(ConfigError, match="the fields are data, header, range, ranges"):
        compile_filter("m.rnage < 1")(Range(), "/sonar")


def test_a_type_that_does_not_fit_is_a_config_error() -> None:
    with pytest.raises(ConfigError, match="does not work"):
        compile_filter("m.range < 'a'")(Range(), "/sonar")
