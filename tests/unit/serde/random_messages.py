"""Messages with random values from a seeded generator: the same ones in every run, odd values among them."""

from __future__ import annotations

import random
import struct
from typing import Any

from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct
from rostether.serde.values import Message

TEXTS = [
    "", "hello", "a b", " padded ", "quoted \"twice\" 'once'", "back\\slash", "line\nbreak", "tab\there",
    "bell\a", "yes", "null", "~", "1", "1.5", "1e3", "- item", "key: value", "# comment", "{brace}",
    "[bracket]", "!tag", "&a", "*a", "%", "@", "`", "|", ">", "?", ":", "-", "---", "...", ",", "=", "<<",
    "2020-01-01", "0x10", "1:30", "hé", "日本語", "\u00a0", "\u0085", "\u2028", "\ufeff", "\U0001f600", "\0",
    "x" * 70, "x" * 71, "x" * 200, "word " * 30, "éé " * 40, "a  b" * 25, "trailing ", "/base_link", "map",
]  # fmt: skip
FLOATS = [0.0, -0.0, 1.0, -1.5, 0.1, 1e-7, 1e16, 1e22, 123456789.123, 5e-324, float("inf"), float("-inf")]


class RandomMessages:
    """Draws messages. `wild` values are those that genpy changes when it reads them."""

    def __init__(self, seed: int, *, wild: bool = False) -> None:
        self._random = random.Random(seed)
        self._wild = wild

    def message(self, codec: Codec) -> Message:
        return codec.conform(self._fields(codec.tree))

    def _fields(self, tree: Struct) -> dict[str, Any]:
        return {member.name: self._value(member.node) for member in tree.members}

    def _value(self, node: Node) -> Any:
        if isinstance(node, Number):
            return self._number(node)
        if isinstance(node, Stamp):
            return self._stamp(node)
        if isinstance(node, Array):
            count = self._random.randrange(4) if node.length is None else node.length
            return (
                self._random.randbytes(count)
                if node.is_bytes
                else [self._value(node.element) for _ in range(count)]
            )
        return self._fields(node) if isinstance(node, Struct) else self._text()

    def _text(self) -> str:
        if self._wild and self._random.random() < 0.3:
            return self._random.randbytes(self._random.randrange(9)).decode("utf-8", "surrogateescape")
        return self._random.choice(TEXTS)

    def _stamp(self, node: Stamp) -> Time | Duration:
        nsecs = self._random.choice((0, 5, 123456789, 999999999))
        if self._wild:
            nsecs = self._random.choice(
                (1000000000, 2147483647, -1 if node.name == "duration" else 4294967295)
            )
        if node.name == "time":
            return Time(self._random.choice((0, 1, 1700000000, 4294967290)), nsecs)
        return Duration(self._random.choice((0, -1, 7, -2147483640, 2147483640)), nsecs)

    def _number(self, node: Number) -> bool | int | float:
        if node.code == "?":
            return self._random.random() < 0.5
        if node.code in "fd":
            value = self._random.choice([*FLOATS, self._random.uniform(-100, 100)])
            exact: float = struct.unpack("<f", struct.pack("<f", value))[0] if node.code == "f" else value
            return exact
        bits = 8 * node.fixed_size_bytes
        low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if node.code.islower() else (0, (1 << bits) - 1)
        return self._random.choice((low, high, 0, 1, self._random.randint(low, high)))
