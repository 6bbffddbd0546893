from __future__ import annotations

import pytest

from rostether.firmware.diagnostics import MAX_REPORTED, typographic_errors


def explain(text: str) -> list[str]:
    return typographic_errors(text, "a.ino")


@pytest.mark.parametrize(
    ("text", "place", "plain"),
    [
        ("#include \u201cros.h\u201d", "1:10", '"'),
        ("int a;\nnh.advertise(\u2018x');", "2:14", "'"),
        ("int\u00a0a;", "1:4", "a space"),
        ("a \u2013 b", "1:3", "-"),
        ("a\u200b;", "1:2", "nothing"),
        ('p("chatter\u201d, &m);\n', "1:11", '"'),
    ],
)
def test_a_typographic_character_in_code_is_named(text: str, place: str, plain: str) -> None:
    assert explain(text)[0].startswith(f"a.ino:{place}: error: ")
    assert explain(text)[0].endswith(f"comes from a web page or PDF; type {plain} instead")


@pytest.mark.parametrize(
    "text", ['s = "\u201cfine\u201d";', "// \u201cfine\u201d", "int a = 1;", "/* \u2013 */"]
)
def test_texts_and_comments_may_contain_any_character(text: str) -> None:
    assert explain(text) == []


def test_a_page_full_of_them_is_shortened() -> None:
    assert len(explain("\u201d\n" * 100)) == MAX_REPORTED
