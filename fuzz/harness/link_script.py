"""Reads fuzz input as a script for a link: pieces of noise and whole frames, with pauses between them."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import NamedTuple

from fuzz.grammar import frame, noise
from rostether.rosserial.frame import encode_frame

MAX_STEPS = 200
MAX_BODY_BYTES = 255
_FRAME, _IS_LEFT = 1, 8
_PAUSES = (0.0, 0.01, 0.3, 4.0)


class Step(NamedTuple):
    """The received data, the pause before it, and whether the output of the link is read after it."""

    received: bytes
    pause_s: float
    is_taken: bool


def steps(data: bytes) -> Iterator[Step]:
    """Yield the steps of a script.

    A step begins with its kind (bit 0: a frame, whose topic id follows; 1 and 2: the pause; 3: no output is
    read) and its length.
    """
    position = 0
    for _ in range(MAX_STEPS):
        if position + 3 > len(data):
            return
        kind, topic_id, size = data[position : position + 3]
        body = data[position + 3 : position + 3 + size]
        position += 3 + size
        received = encode_frame(topic_id, body) if kind & _FRAME else body
        yield Step(received, _PAUSES[(kind >> 1) & 3], not kind & _IS_LEFT)


def step(topic_id: int, body: bytes, *, kind: int = 1) -> bytes:
    """Return the bytes of one step."""
    return bytes([kind, topic_id, len(body)]) + body


def random_step(source: random.Random, topic_id: int, body: bytes) -> bytes:
    """Return a step with a frame, usually complete, after a pause; one in eight is followed by noise."""
    kind = source.choice((0, 0, 0, 1, 1, 2, 3)) << 1 | (_IS_LEFT if source.random() < 0.2 else 0)
    data = frame(source, topic_id, body)
    made = (
        step(0, data, kind=kind) if len(data) <= MAX_BODY_BYTES else step(topic_id, body, kind=kind | _FRAME)
    )
    return made + step(0, noise(source), kind=kind) if source.random() < 0.125 else made


def burst(source: random.Random, topic_id: int, body: bytes) -> bytes:
    """Return a step with as many frames as fit into it."""
    data = encode_frame(topic_id, body)
    return step(0, data * source.randint(1, MAX_BODY_BYTES // len(data)), kind=source.choice((0, _IS_LEFT)))
