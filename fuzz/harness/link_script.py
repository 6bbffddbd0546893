"""Reading fuzz input as a script for a link: pieces of noise and whole frames, with time between them."""

from __future__ import annotations

from collections.abc import Iterator

from rostether.rosserial.frame import encode_frame

MAX_STEPS = 200


def steps(data: bytes) -> Iterator[tuple[bytes, float]]:
    """Yield what arrives and how long before it time went by, in seconds.

    A step begins with its kind (even: noise; odd: a frame, whose topic id follows) and its length.
    """
    position = 0
    for _ in range(MAX_STEPS):
        if position + 3 > len(data):
            return
        kind, topic_id, size = data[position : position + 3]
        body = data[position + 3 : position + 3 + size]
        position += 3 + size
        pause_s = (0.0, 0.01, 0.3, 4.0)[(kind >> 1) & 3]
        yield (encode_frame(topic_id, body) if kind & 1 else body), pause_s


def step(topic_id: int, body: bytes, *, kind: int = 1) -> bytes:
    """Return the bytes of one step."""
    return bytes([kind, topic_id, len(body)]) + body
