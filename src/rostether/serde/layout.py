"""Checks whether raw bytes have the layout of a type, without decoding them.

One damaged frame in 256 passes its checksum, but its content must never reach ROS. The check runs for every
message, so it is compiled for each type. It compares lengths if the size is constant; otherwise, it walks
over the lengths in the payload.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct as Packing
from typing import Final

from rostether.mechanisms.text import counted
from rostether.serde.layout_source import compile_layout
from rostether.serde.type_tree import Array, Node, Struct, Text

_UNPACK_U32: Final = Packing("<I").unpack_from


class Layout:
    """The layout of one message type. Nothing here raises, whatever the bytes are."""

    __slots__ = ("_tree", "accepts", "accepts_all", "fixed_size_bytes")

    # Return whether a payload is exactly one message.
    accepts: Callable[[bytes], bool]

    # Return whether every payload of a batch is exactly one message; True for an empty batch.
    accepts_all: Callable[[Sequence[bytes]], bool]

    def __init__(self, tree: Struct) -> None:
        self._tree = tree

        # The size in bytes of every message of the type, None if it varies.
        self.fixed_size_bytes = tree.fixed_size_bytes
        if tree.fixed_size_bytes is None:
            self.accepts, self.accepts_all = compile_layout(tree)
        else:
            self.accepts, self.accepts_all = _fixed_size_checks(tree.fixed_size_bytes)

    @property
    def smallest_size_bytes(self) -> int:
        """The size in bytes of the type's smallest message: strings empty, arrays as short as they may be."""
        return smallest_size(self._tree)

    @property
    def has_varying_elements(self) -> bool:
        """Whether there are arrays whose elements are checked one by one, because their size varies."""
        return _has_varying_elements(self._tree)

    @property
    def type_name(self) -> str:
        """The type as `package/Name`."""
        return self._tree.name

    def explain(self, payload: bytes) -> str:
        """Return how a payload differs from the layout, in one line without a full stop."""
        walk = _Walk(payload)
        try:
            walk.over(self._tree, "")
        except _Misfit as reason:
            return f"the payload of {counted(len(payload), 'byte')} {reason} of {self._tree.name}"
        extra_bytes = len(payload) - walk.at
        if extra_bytes:
            return f"the payload has {counted(extra_bytes, 'byte')} more than {self._tree.name}"
        return f"the payload fits {self._tree.name}"


def _has_varying_elements(node: Node) -> bool:
    if isinstance(node, Array):
        return node.element.fixed_size_bytes is None
    return isinstance(node, Struct) and any(_has_varying_elements(member.node) for member in node.members)


def smallest_size(node: Node) -> int:
    """Return the size in bytes of the smallest value: strings empty, arrays as short as they may be."""
    if node.fixed_size_bytes is not None:
        return node.fixed_size_bytes
    if isinstance(node, Array):
        return 4 if node.length is None else node.length * smallest_size(node.element)
    if isinstance(node, Struct):
        return sum(smallest_size(member.node) for member in node.members)
    return 4


def _fixed_size_checks(size: int) -> tuple[Callable[[bytes], bool], Callable[[Sequence[bytes]], bool]]:
    sizes = frozenset((size,))

    def accepts(payload: bytes) -> bool:
        return len(payload) == size

    def accepts_all(payloads: Sequence[bytes]) -> bool:
        return sizes.issuperset(map(len, payloads))

    return accepts, accepts_all


class _Misfit(Exception):  # noqa: N818
    """Ends a walk; the text is the reason."""


class _Walk:
    """Walks over a payload field by field: slow, but with the position for errors."""

    def __init__(self, payload: bytes) -> None:
        self.at = 0
        self._payload = payload

    def over(self, node: Node, path: str) -> None:
        """Walk over one value. Raises _Misfit."""
        if node.fixed_size_bytes is not None and not isinstance(node, Struct):
            self._skip(node.fixed_size_bytes, path)
        elif isinstance(node, Text):
            self._skip(self._length(path), path)
        elif isinstance(node, Array):
            self._over_array(node, path)
        else:
            assert isinstance(node, Struct)
            for member in node.members:
                self.over(member.node, f"{path}.{member.name}" if path else member.name)

    def _over_array(self, array: Array, path: str) -> None:
        count = self._length(path) if array.length is None else array.length
        size = array.element.fixed_size_bytes
        if array.max_count is not None and count > array.max_count:
            limit = f"more than the limit of {array.max_count}"
            raise _Misfit(f"announces {count} elements in field '{path}', {limit}")
        if size is not None:
            self._skip(count * size, path)
            return
        for index in range(count):
            self.over(array.element, f"{path}[{index}]")

    def _length(self, path: str) -> int:
        start = self.at
        self._skip(4, path)
        length: int = _UNPACK_U32(self._payload, start)[0]
        return length

    def _skip(self, size: int, path: str) -> None:
        missing_bytes = self.at + size - len(self._payload)
        if missing_bytes > 0:
            raise _Misfit(f"ends {counted(missing_bytes, 'byte')} early in field '{path}'")
        self.at += size
