"""Hypothesis strategies for the values of any message type, as decoding returns them."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct
from rostether.serde.values import Message

MAX_ELEMENTS = 3
"""The largest number of elements of a variable array: enough for none, one and more than one."""


def messages(codec: Codec, texts: st.SearchStrategy[str] | None = None) -> st.SearchStrategy[Message]:
    """Return messages of the codec's type with any values except NaN (which does not equal itself)."""
    return _fields(codec.tree, raw_texts() if texts is None else texts).map(codec.conform)


def raw_texts() -> st.SearchStrategy[str]:
    """Return strings as decoding returns them: any bytes, those that are not UTF-8 as surrogates."""
    raw = st.text(max_size=12).map(str.encode) | st.binary(max_size=12)
    return raw.map(lambda value: value.decode("utf-8", "surrogateescape"))


def _fields(tree: Struct, texts: st.SearchStrategy[str]) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries({member.name: _values(member.node, texts) for member in tree.members})


def _values(node: Node, texts: st.SearchStrategy[str]) -> st.SearchStrategy[Any]:
    if isinstance(node, Number):
        return _numbers(node)
    if isinstance(node, Stamp):
        if node.name == "time":
            return st.builds(Time, st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
        return st.builds(Duration, st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1))
    if isinstance(node, Array):
        low, high = (0, MAX_ELEMENTS) if node.length is None else (node.length, node.length)
        if node.is_bytes:
            return st.binary(min_size=low, max_size=max(high, low))
        return st.lists(_values(node.element, texts), min_size=low, max_size=high)
    return _fields(node, texts) if isinstance(node, Struct) else texts


def _numbers(node: Number) -> st.SearchStrategy[Any]:
    if node.code == "?":
        return st.booleans()
    bits = 8 * node.fixed_size_bytes
    if node.code in "fd":
        return st.floats(width=32 if bits == 32 else 64, allow_nan=False)
    if node.code.islower():
        return st.integers(-(1 << bits - 1), (1 << bits - 1) - 1)
    return st.integers(0, (1 << bits) - 1)
