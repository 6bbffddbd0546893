"""Definitions are resolved to trees, and what could exhaust memory is refused before anything is made."""

from __future__ import annotations

import pytest

from rostether.errors import DefinitionError, UnknownTypeError
from rostether.serde.type_tree import MAX_DEPTH, MAX_EMPTY_ELEMENTS, MAX_ZERO_ELEMENTS
from unit.serde.definitions import store_of


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("", 0),
        ("int8 a\nuint16 b\nfloat32 c\nint64 d\ntime e\nduration f\nbool g\nbyte h\nchar i", 34),
        ("geometry_msgs/Pose[3] poses", 168),
        ("string[0] none", 0),
        ("string a", None),
        ("int8[] a", None),
        ("Header header", None),
        ("string[2] a", None),
    ],
)
def test_size(text: str, size: int | None) -> None:
    assert store_of(Sized=text).layout("test/Sized").fixed_size_bytes == size


def test_type_that_contains_itself() -> None:
    store = store_of(A="B[] b", B="int8 x\nA a")
    with pytest.raises(DefinitionError, match=r"test/A -> test/B -> test/A"):
        store.layout("test/A")


def test_unknown_type_below() -> None:
    with pytest.raises(UnknownTypeError, match="missing_msgs"):
        store_of(A="missing_msgs/Thing thing").layout("test/A")


def test_nesting_is_bounded() -> None:
    texts = {f"D{level}": f"D{level - 1}[] d" for level in range(1, 3 * MAX_DEPTH)}
    store = store_of(D0="string s", **texts)
    with pytest.raises(DefinitionError, match="deep"):
        store.layout(f"test/D{3 * MAX_DEPTH - 1}")
    assert store.layout(f"test/D{MAX_DEPTH // 2}").accepts(bytes(4))
    deepest = store.codec(f"test/D{MAX_DEPTH - 1}")
    assert deepest.decode(deepest.encode(deepest.message_class())) == deepest.message_class()
    with pytest.raises(DefinitionError, match="deep"):
        store.layout(f"test/D{MAX_DEPTH}")


@pytest.mark.parametrize(
    "text",
    [
        "float64[10000000] a",
        "Big[100] a",
        f"string[{MAX_ZERO_ELEMENTS + 1}] a",
        f"std_msgs/String[{MAX_ZERO_ELEMENTS // 2 + 1}] a",
        f"std_msgs/Empty[{MAX_EMPTY_ELEMENTS + 1}] a",
        "Empties[200] a",
    ],
)
def test_zero_values_that_would_not_fit(text: str) -> None:
    store = store_of(A=text, Big="uint8[1000000] a", Empties="std_msgs/Empty[200] a")
    with pytest.raises(DefinitionError, match=r"more than the limit of \d+"):
        store.codec("test/A")
