"""The generated classes read and write the same bytes as the codec, for every type."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

import pytest

from rostether.codegen.arduino_library import WrittenLibrary
from rostether.codegen.type_index import TypeIndex
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore
from unit.codegen.cpp_assignments import Assignments
from unit.codegen.wire_program import WireProgram
from unit.serde.random_messages import RandomMessages

pytestmark = [pytest.mark.gcc, pytest.mark.timeout(900)]

MESSAGES_PER_TYPE = 6
DAMAGES_PER_TYPE = 8


class _CStrings(RandomMessages):
    """Removes NULs, at which a string ends in C++."""

    def _text(self) -> str:
        return super()._text().replace("\0", "0")


@dataclass(frozen=True)
class Bench:
    """The program, all types, and for each type a message with the values that the program sets."""

    program: WireProgram
    store: TypeStore
    types: list[str]
    filled: list[tuple[str, Any]]


@pytest.fixture(scope="module")
def bench(hostile_registry: Registry, hostile_library: WrittenLibrary) -> Bench:
    index = TypeIndex(hostile_registry)
    types = [spec.full_name for name in hostile_library.library.types for spec in index.specs(name)]
    store = TypeStore(hostile_registry)
    draw, assignments = _CStrings(seed=3), Assignments(hostile_registry)
    filled = [(name, draw.message(store.codec(name))) for name in types]
    bodies = [(name, assignments.body(hostile_registry.message(name), message)) for name, message in filled]
    return Bench(WireProgram(index, hostile_library.path, types, bodies), store, types, filled)


def test_fields_have_the_values_of_their_names(bench: Bench) -> None:
    for (name, message), answer in zip(bench.filled, bench.program.filled(len(bench.filled)), strict=True):
        expected = bench.store.codec(name).encode(message)
        assert (name, answer.written, answer.payload) == (name, len(expected), expected)


def test_messages_are_read_and_written_back(bench: Bench) -> None:
    draw = _CStrings(seed=4)
    cases = [
        (name, bench.store.codec(name).encode(draw.message(bench.store.codec(name))))
        for name in bench.types
        for _ in range(MESSAGES_PER_TYPE)
    ]
    assert len(bench.types) > 170
    for (name, payload), answer in zip(cases, bench.program.round_trips(cases), strict=True):
        assert (name, answer.read, answer.payload) == (name, len(payload), payload)


def test_invalid_messages_are_refused(bench: Bench) -> None:
    rng = random.Random(5)
    draw = _CStrings(seed=6)
    cases = []
    for name in bench.types:
        codec = bench.store.codec(name)
        for _ in range(DAMAGES_PER_TYPE):
            cases.append((name, _damaged(codec.encode(draw.message(codec)), rng)))
    refused = 0
    for (name, payload), answer in zip(cases, bench.program.round_trips(cases), strict=True):
        accepted = bench.store.layout(name).accepts(payload)
        refused += not accepted
        assert (name, payload, answer.read >= 0) == (name, payload, accepted)
    assert refused > len(cases) / 4


def _damaged(payload: bytes, rng: random.Random) -> bytes:
    kind = rng.randrange(4)
    if kind == 0:
        return payload[: rng.randrange(len(payload) + 1)]
    if kind == 1:
        return payload + rng.randbytes(rng.randrange(1, 9))
    damaged = bytearray(payload)
    for _ in range(min(kind, len(damaged))):
        damaged[rng.randrange(len(damaged))] = rng.choice((0, 1, 2, 127, 128, 255))
    return bytes(damaged)
