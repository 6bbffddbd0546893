"""Generates inputs from a seed: with the grammar of a target, and by random changes of known inputs.

Random changes test how readers handle damage. States behind a checksum, a length or a negotiation are only
reached by inputs that are valid except for one detail.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence

# Harnesses lower the limits that they test, so that this exceeds each of them.
MAX_INPUT_BYTES = 16 * 1024
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


def mutated(
    corpus: Sequence[bytes], seed: int, generate: Callable[[random.Random], bytes]
) -> Iterator[bytes]:
    """Yield inputs without end; the same seed, corpus and grammar give the same ones.

    Half are from the grammar, a quarter are changed inputs of the grammar, a quarter those of the corpus.
    """
    source = random.Random(seed)
    while True:
        chance = source.random()
        data = bytearray(generate(source) if chance < 0.75 else source.choice(corpus))
        if chance >= 0.5:
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
