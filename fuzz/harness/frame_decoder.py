"""The frame decoder: garbage never raises, chunks do not change the result, and its buffer is bounded.

Its frames are compared with those of a simple reader that follows the specification byte by byte.
"""

from __future__ import annotations

import random

from fuzz.grammar import frame, near, noise
from rostether.rosserial.frame import FORMS, encode_frame, encode_frames
from rostether.rosserial.frame_decoder import Decoded, FrameDecoder, Frames
from vectors.captures import load, names

HEADER_BYTES = 8
SEED_BYTES = 4000
MAX_PAYLOAD_BYTES = 300


def seeds() -> list[bytes]:
    """Return recorded sessions, and frames with a wrong length."""
    made = [bytes([version]) + encode_frame(125, b"abc", version=version) for version in FORMS]
    made.append(b"\x02" + encode_frames(10, [b"", b"x" * 300]) + b"\xff\xfe\xff\xff\x00")
    return made + [
        b"\x02" + b"".join(each.data for each in capture.of_device())[:SEED_BYTES]
        for capture in map(load, names())
    ]


def generate(source: random.Random) -> bytes:
    """Return frames of one version with noise and damage between them, sometimes many frames of one topic."""
    choice = source.randrange(256)
    version = tuple(FORMS)[choice % len(FORMS)]
    parts = []
    for _ in range(source.randint(1, 8)):
        size = near(source, MAX_PAYLOAD_BYTES) % 400 if source.random() < 0.3 else source.randint(0, 12)
        topic_id, payload = source.choice((0, 10, 101, 125, 0xFFFF)), source.randbytes(size)
        parts += [frame(source, topic_id, payload, version) for _ in range(source.choice((1, 1, 3)))]
        if source.random() < 0.5:
            parts.append(noise(source))
    return bytes([choice]) + b"".join(parts)


def run(data: bytes) -> None:
    """Decode the data in one piece and in two, and with the simple reader."""
    version = (1, 2)[data[0] % 2] if data else 1
    stream = data[1:]
    whole, cut = (FrameDecoder(version, max_payload_bytes=MAX_PAYLOAD_BYTES) for _ in range(2))
    found = whole.feed(stream, 0.0)
    middle = data[0] * len(stream) // 256 if data else 0
    pieces = [*cut.feed(stream[:middle], 0.0), *cut.feed(stream[middle:], 0.0)]
    assert messages(pieces) == messages(found), "the chunks change what is decoded"
    assert whole.pending_bytes <= MAX_PAYLOAD_BYTES + HEADER_BYTES
    expected = read_slowly(stream, version)
    assert messages([*found, *whole.abandon(1e6)]) == expected, "the simple reader finds other frames"
    whole.handle_timer(1e6)


def messages(decoded: list[Decoded]) -> dict[int, list[bytes]]:
    """Return the payloads by topic id, each in order; the order between topics is not kept."""
    found: dict[int, list[bytes]] = {}
    for each in decoded:
        if isinstance(each, Frames):
            found.setdefault(each.topic_id, []).extend(each.payloads)
    return found


def read_slowly(stream: bytes, version: int) -> dict[int, list[bytes]]:
    """Return the payloads by topic id: if no valid frame begins at a byte, try the next one."""
    found: dict[int, list[bytes]] = {}
    place = 0
    while place < len(stream):
        taken = _frame_at(stream[place:], version)
        if taken is None:
            place += 1
            continue
        topic_id, payload, size = taken
        found.setdefault(topic_id, []).append(payload)
        place += size
    return found


def _frame_at(data: bytes, version: int) -> tuple[int, bytes, int] | None:
    if version == 1:
        if len(data) < 7 or data[:2] != b"\xff\xff":
            return None
        topic_id, size, start = data[2] + 256 * data[3], data[4] + 256 * data[5], 6
        summed_from = 2
    else:
        if len(data) < 8 or data[:2] != b"\xff\xfe" or sum(data[2:5]) % 256 != 255:
            return None
        topic_id, size, start = data[5] + 256 * data[6], data[2] + 256 * data[3], 7
        summed_from = 5
    end = start + size + 1
    if size > MAX_PAYLOAD_BYTES or len(data) < end or sum(data[summed_from:end]) % 256 != 255:
        return None
    return topic_id, data[start : end - 1], end
