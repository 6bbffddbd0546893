"""Changing inputs at random, from a seed: where atheris is not installed, and for the short run in tests."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence

MAX_INPUT_BYTES = 4096
_INTERESTING = (
    b"\0",
    b"\xff",
    b"\xff\xff\xff\xff",
    b"\x7f\xff\xff\xff",
    b"\0\0\0\x80",
    b"\xff\xfe",
    b"\n",
    b"]]",
    b'"',
)


def mutated(corpus: Sequence[bytes], seed: int) -> Iterator[bytes]:
    """Yield changed inputs without end; the same seed and corpus give the same ones."""
    source = random.Random(seed)
    while True:
        data = bytearray(source.choice(corpus))
        for _ in range(source.randint(1, 6)):
            source.choice(_CHANGES)(data, source, corpus)
        yield bytes(data[:MAX_INPUT_BYTES])


def _flip(data: bytearray, source: random.Random, _corpus: Sequence[bytes]) -> None:
    if data:
        data[source.randrange(len(data))] ^= 1 << source.randrange(8)


def _replace(data: bytearray, source: random.Random, _corpus: Sequence[bytes]) -> None:
    if data:
        data[source.randrange(len(data))] = source.randrange(256)


def _insert(data: bytearray, source: random.Random, _corpus: Sequence[bytes]) -> None:
    place = source.randint(0, len(data))
    data[place:place] = source.choice(_INTERESTING) if source.random() < 0.5 else source.randbytes(4)


def _delete(data: bytearray, source: random.Random, _corpus: Sequence[bytes]) -> None:
    start = source.randint(0, len(data))
    del data[start : start + source.randint(1, 16)]


def _repeat(data: bytearray, source: random.Random, _corpus: Sequence[bytes]) -> None:
    start = source.randint(0, len(data))
    data[start:start] = data[start : start + source.randint(1, 64)] * source.randint(1, 20)


def _cut(data: bytearray, source: random.Random, _corpus: Sequence[bytes]) -> None:
    del data[source.randint(0, len(data)) :]


def _splice(data: bytearray, source: random.Random, corpus: Sequence[bytes]) -> None:
    other = source.choice(corpus)
    start = source.randint(0, len(other))
    place = source.randint(0, len(data))
    data[place:place] = other[start : start + source.randint(1, 256)]


_CHANGES = (_flip, _replace, _replace, _insert, _delete, _repeat, _cut, _splice)
