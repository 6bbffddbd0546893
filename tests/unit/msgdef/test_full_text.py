from __future__ import annotations

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.full_text import (
    MAX_FULL_TEXT_CHARACTERS,
    MAX_PARTS,
    SEPARATOR,
    message_full_text,
    split_full_text,
)
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec

TEXTS = {"p/A": "B b\nC c # comment\n", "p/B": "C[] c\n", "p/C": "int8 x"}
FULL = f"B b\nC c # comment\n\n{SEPARATOR}\nMSG: p/B\nC[] c\n\n{SEPARATOR}\nMSG: p/C\nint8 x"


def lookup(name: str) -> MessageSpec:
    return parse_message(TEXTS[name], package="p", name=name.removeprefix("p/"))


def test_all_parts_follow_in_order_with_their_comments() -> None:
    assert message_full_text(lookup("p/A"), lookup) == FULL
    assert message_full_text(lookup("p/C"), lookup) == "int8 x"


def test_splitting_gives_the_parts_back() -> None:
    assert split_full_text("p/A", FULL) == TEXTS
    assert list(split_full_text("p/A", FULL)) == list(TEXTS)


def test_every_bundled_type_survives_the_round_trip() -> None:
    registry = Registry()
    for name in registry.messages():
        for part, text in split_full_text(name, registry.message_type(name).definition).items():
            assert text == registry.message(part).text


def test_parts_may_be_empty_and_headings_may_have_blanks() -> None:
    assert split_full_text("p/A", f"{SEPARATOR}\nMSG:   p/B  \n") == {"p/A": "", "p/B": ""}
    assert split_full_text("p/A", "") == {"p/A": ""}
    assert split_full_text("p/A", f"B b\r\n{SEPARATOR}\r\nMSG: p/B\r\nint8 x") == {
        "p/A": "B b\r",
        "p/B": "int8 x",
    }


def test_the_first_of_two_parts_with_one_name_counts() -> None:
    assert split_full_text("p/A", f"int8 a\n{SEPARATOR}\nMSG: p/A\nint8 b") == {"p/A": "int8 a"}


@pytest.mark.parametrize(
    ("definition", "reason"),
    [
        (f"int8 a\n{SEPARATOR}\nint8 b", "p/A:3: 'MSG:"),
        ("#" * (MAX_FULL_TEXT_CHARACTERS + 1), "more than"),
        ("".join(f"{SEPARATOR}\nMSG: p/N{n}\n" for n in range(MAX_PARTS + 2)), "parts"),
    ],
)
def test_other_texts_are_refused(definition: str, reason: str) -> None:
    with pytest.raises(DefinitionError, match=reason):
        split_full_text("p/A", definition)
