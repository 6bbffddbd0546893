from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rostether.firmware.cpp_tokens import code_tokens, tokenize


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ("a::b->c", ["name", "punctuation", "name", "punctuation", "name"]),
        ("\"a\\\"b\" '\\''", ["string", "char"]),
        ('R"x(a"b)")x" u8"q"', ["string", "string"]),
        ("// a \\\n still a comment\nb", ["comment", "name"]),
        ("/* { */ x", ["comment", "name"]),
        ("#define A /* x\n y */ 3\nz", ["directive", "name"]),
        ("#define A \\\n 3\nz", ["directive", "name"]),
        ("1.5e-3f 0x1F", ["number", "number"]),
        ('"not closed\nx', ["string", "name"]),
        ("a == b", ["name", "punctuation", "name"]),
    ],
)
def test_kinds(text: str, kinds: list[str]) -> None:
    assert [token.kind for token in tokenize(text)] == kinds


@given(st.text(alphabet="ab{}()\"'/*\\\n#R<>=;“ ", max_size=60))
def test_only_white_space_is_lost(text: str) -> None:
    tokens = list(tokenize(text))
    assert "".join("".join(token.text for token in tokens).split()) == "".join(text.split())
    assert all(text[token.offset : token.end] == token.text for token in tokens)


def test_comments_are_not_code() -> None:
    assert [token.text for token in code_tokens("a /* b */ c // d")] == ["a", "c"]
