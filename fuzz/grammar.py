"""Parts that the grammars of several targets share: numbers near limits, noise, names, frames."""

from __future__ import annotations

import random
import struct

from rostether.rosserial.frame import encode_frame

_EDGES = (0, 1, 7, 8, 255, 256, 65535, 2**31 - 1, 2**31, 2**32 - 1)
_NOISE = (b"\xff", b"\xfe", b"\xff\xfe", b"\xff\xff", b"\0", b"boot\r\n")
_NAMES = ("chatter", "led", "a", "arm/joint", "/imu", "~gains", "b_2")


def near(source: random.Random, limit: int) -> int:
    """Return a number at a limit, next to it, far below it, or at the limit of an integer type."""
    chance = source.random()
    if chance < 0.5:
        return max(limit + source.choice((-1, 0, 0, 1, 2)), 0)
    return source.choice(_EDGES) if chance < 0.6 else source.randint(0, max(limit, 1))


def noise(source: random.Random, most_bytes: int = 12) -> bytes:
    """Return a few bytes that are usually not a frame, sometimes with the beginning of one."""
    parts = [source.choice(_NOISE) if source.random() < 0.6 else source.randbytes(2) for _ in range(3)]
    return b"".join(parts)[: source.randint(1, most_bytes)]


def name(source: random.Random) -> str:
    """Return a ROS name; one in eight is unusual or invalid."""
    if source.random() < 0.875:
        return source.choice(_NAMES)
    return source.choice(("", "/", "a b", "2x", "~", "a//b", "\u00e4", "x" * 255, "x" * 256))


def damaged(source: random.Random, data: bytes) -> bytes:
    """Return the data with one byte changed, removed or inserted."""
    place = source.randrange(len(data) or 1)
    kept = source.choice((0, 1, 1))
    return data[:place] + source.randbytes(source.choice((0, 1, 1))) + data[place + kept :]


def frame(source: random.Random, topic_id: int, payload: bytes, version: int = 2) -> bytes:
    """Return a frame; one in ten is damaged or cut short."""
    data = encode_frame(topic_id, payload, version)
    chance = source.random()
    if chance < 0.05:
        return damaged(source, data)
    return data[: source.randrange(len(data))] if chance < 0.1 else data


def string(data: bytes) -> bytes:
    """Return a serialized string: the length, then the bytes."""
    return struct.pack("<I", len(data)) + data
