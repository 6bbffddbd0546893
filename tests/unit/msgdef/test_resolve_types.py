from __future__ import annotations

import pytest

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.resolve_types import MAX_DEPTH, dependencies
from rostether.msgdef.spec import MessageSpec


class Texts:
    """Looks up texts of the package `p`, and counts the lookups of each."""

    def __init__(self, **texts: str) -> None:
        self.texts = texts
        self.asked: list[str] = []

    def __call__(self, name: str) -> MessageSpec:
        self.asked.append(name)
        short_name = name.removeprefix("p/")
        if short_name not in self.texts:
            raise UnknownTypeError(f"no {name}; give it")
        return parse_message(self.texts[short_name], package="p", name=short_name)

    def below(self, name: str) -> list[str]:
        return [spec.name for spec in dependencies(self(f"p/{name}"), self)]


def test_order_is_that_of_first_use_depth_first() -> None:
    texts = Texts(A="C c\nB b\nD[] d", B="D d\nE[2] e", C="int8 x", D="C c", E="")
    assert texts.below("A") == ["C", "B", "D", "E"]


def test_each_type_is_looked_up_once() -> None:
    texts = Texts(**{f"L{level}": f"L{level + 1} a\nL{level + 1} b" for level in range(15)}, L15="int8 x")
    assert len(texts.below("L0")) == 15
    assert len(texts.asked) == len(set(texts.asked))


def test_primitives_have_no_dependencies() -> None:
    assert Texts(A="int8 a\nstring[] b\ntime c").below("A") == []


def test_a_missing_type_is_named_with_the_field_that_needs_it() -> None:
    with pytest.raises(UnknownTypeError, match="p/B, field 'c': no p/Missing; give it"):
        Texts(A="B b", B="Missing[] c").below("A")


def test_a_message_cannot_contain_itself() -> None:
    with pytest.raises(DefinitionError, match="p/B: a message cannot contain itself: p/A -> p/B -> p/A"):
        Texts(A="B[] b", B="A a").below("A")
    with pytest.raises(DefinitionError, match="p/A -> p/A"):
        Texts(A="A a").below("A")
    with pytest.raises(DefinitionError, match=": p/B -> p/C -> p/B"):
        Texts(A="B b", B="C c", C="B b").below("A")


def test_nesting_is_bounded() -> None:
    def chain(length: int) -> Texts:
        return Texts(**{f"L{n}": f"L{n + 1} x" for n in range(length - 1)}, **{f"L{length - 1}": "int8 x"})

    assert len(chain(MAX_DEPTH).below("L0")) == MAX_DEPTH - 1
    with pytest.raises(DefinitionError, match="deeper"):
        chain(MAX_DEPTH + 1).below("L0")


@pytest.mark.parametrize(
    "texts",
    [
        {"A": "B[4096] b", "B": "C[4096] c", "C": "int8 x"},
        {"A": "float64[16000000] x"},
        {"A": "\n".join(f"uint8[16000000] x{n}" for n in range(20))},
        {**{chr(ord("A") + n): "{0} a\n{0} b".format(chr(ord("B") + n)) for n in range(21)}, "V": "int8 x"},
    ],
)
def test_a_message_that_is_always_huge_is_refused(texts: dict[str, str]) -> None:
    with pytest.raises(DefinitionError, match="variable length"):
        Texts(**texts).below("A")


def test_large_fixed_byte_arrays_and_variable_arrays_are_fine() -> None:
    assert Texts(A="uint8[6220800] image\nB[] many", B="float64[1000000] x").below("A") == ["B"]
