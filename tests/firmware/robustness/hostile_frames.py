"""Invalid frames for the Target sketch, with any length, id, content and damage, and noise."""

from __future__ import annotations

import random
import struct

from rostether.rosserial.frame import encode_frame

# The sketch's subscriptions.
NUMBERS, TEXTS, REALS, JOINTS, TRANSFORMS, DIAGNOSTICS, SERVER = range(100, 107)
NUMBERS_OUT = 108
MAX_BYTES = 400
_LENGTHS = (
    0,
    1,
    2,
    3,
    7,
    8,
    127,
    255,
    256,
    280,
    65535,
    0x10000,
    0x20000000,
    0x7FFFFFFF,
    0x80000000,
    0xFFFFFFFF,
)


def _text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def _header() -> bytes:
    return struct.pack("<III", 7, 100, 200) + _text("frame")


def _reals(*values: float) -> bytes:
    return struct.pack(f"<I{len(values)}d", len(values), *values)


def _status() -> bytes:
    pair = _text("k") + _text("v")
    return b"\x01" + _text("name") + _text("message") + _text("id") + struct.pack("<I", 2) + pair + pair


SAMPLES = (
    (0, b""),
    (6, struct.pack("<IiII", 1, 5, 0, 0)),
    (10, struct.pack("<II", 1_700_000_000, 5)),
    (11, b""),
    (TEXTS, _text("hello world")),
    (TEXTS, _text("x" * 276)),
    (REALS, struct.pack("<I", 1) + _text("label") + struct.pack("<III", 2, 1, 0) + _reals(1.0, -2.5)),
    (
        JOINTS,
        _header() + struct.pack("<I", 2) + _text("a") + _text("b") + _reals(1.0) + _reals() + _reals(0.5),
    ),
    (TRANSFORMS, struct.pack("<I", 1) + _header() + _text("child") + struct.pack("<7d", *range(7))),
    (DIAGNOSTICS, _header() + struct.pack("<I", 2) + _status() + _status()),
    (SERVER, b"\x01"),
)


class HostileFrames:
    """Generates hostile frames; the same seed gives the same frames."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def next(self) -> bytes:
        """Return the bytes of one frame, at most slightly longer than a board's buffer."""
        sample_id, payload = self._random.choice(SAMPLES)
        any_id = self._random.choice((sample_id, self._random.randrange(0x10000), NUMBERS, 6, SERVER))
        kind = self._random.randrange(7)
        if kind == 0:
            return self._noise(MAX_BYTES)
        if kind == 1:
            return encode_frame(any_id, self._noise(MAX_BYTES))
        if kind == 2:
            return self._damage(encode_frame(sample_id, payload))
        if kind == 3:
            frame = encode_frame(sample_id, payload)
            return frame[: self._random.randrange(len(frame))]
        if kind == 4:
            return encode_frame(any_id, payload)
        # A valid frame with damaged content, which reaches the callbacks.
        return encode_frame(sample_id, self._damage(payload))[: 2 * MAX_BYTES]

    def _noise(self, longest: int) -> bytes:
        alphabet = self._random.choice((bytes(range(256)), b"\xff\xfe", bytes(5)))
        return bytes(self._random.choices(alphabet, k=self._random.randrange(longest)))

    def _damage(self, data: bytes) -> bytes:
        damaged = bytearray(data)
        for _ in range(self._random.randint(1, 3)):
            at = self._random.randrange(len(damaged) + 1)
            kind = self._random.randrange(4)
            if kind == 0 and at < len(damaged):
                damaged[at] ^= 1 << self._random.randrange(8)
            elif kind == 1:
                del damaged[at : at + self._random.randint(1, 8)]
            elif kind == 2:
                damaged[at:at] = self._noise(20)
            else:
                damaged[at : at + 4] = struct.pack("<I", self._random.choice(_LENGTHS))
        return bytes(damaged)
