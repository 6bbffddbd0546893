"""Counts how many recent frames were damaged."""

from __future__ import annotations

from collections import deque

from rostether.bridge.findings.finding import Code, Finding, warning
from rostether.bridge.findings.medium import Medium
from rostether.bridge.findings.noise import PIECE_GAP_S
from rostether.rosserial.events import DAMAGE, DiscardReason, FrameDiscarded

# Long enough for a percentage on a board that sends once a second, short enough to show the effect of a new
# cable soon.
WINDOW_S = 30.0

# One or two may be a plug that was touched.
MIN_DAMAGED = 3
# A reset within a frame damages two frames, together with the output of the bootloader.
RESET_DAMAGES = 2

# One in 500: users do not notice less, and radio links are never better.
MIN_SHARE = 0.002

_CABLE_ADVICE = (
    "use a shorter or shielded cable away from motors, check the ground wire, choose a lower baud rate, and "
    "keep every interrupt of the sketch shorter than the time of one byte"
)
_ADVICE = {
    Medium.UDP: (
        "the network loses datagrams: improve the Wi-Fi signal, send messages that fit in a datagram (1400 "
        "bytes), or use TCP"
    ),
    Medium.RADIO: (
        "move the radios closer together, set all of them to another channel, or send messages that fit a "
        "packet (92 bytes, DigiMesh 65)"
    ),
}

_REMAINS = frozenset({DiscardReason.NOISE, DiscardReason.VERSION, DiscardReason.UNFINISHED})
# Stray bytes shorter than a frame do not count.
_MIN_REMAINS_BYTES = 8


class Damage:
    """The damaged frames of one connection."""

    def __init__(self, medium: Medium = Medium.SERIAL) -> None:
        # Behind a TCP connection may be a converter with a serial line.
        self._advice = _ADVICE.get(medium, _CABLE_ADVICE)
        self._count = 0
        self._last_s = float("-inf")
        # Damage without a valid frame after it: the board may have another baud rate now, or be off.
        self._unconfirmed = 0
        self._frame_count = 0
        self._samples: deque[tuple[float, int, int]] = deque()

    def count_discarded(self, event: FrameDiscarded, now_s: float, frame_count: int) -> bool:
        """Count the bytes as a damaged frame after `frame_count` valid ones; return whether they are one.

        Bytes that follow a damaged frame, without a valid frame before them, are the rest of it.
        """
        is_rest = frame_count == self._frame_count and now_s - self._last_s <= PIECE_GAP_S
        is_remains = event.reason in _REMAINS and len(event.data) >= _MIN_REMAINS_BYTES
        is_frame = event.reason in DAMAGE or (is_remains and not is_rest)
        if is_frame:
            self._count += 1
            self._unconfirmed = self._unconfirmed + 1 if frame_count == self._frame_count else 1
            self._frame_count = frame_count
            self._last_s = now_s
        elif is_rest:
            self._last_s = now_s
        return is_frame

    def forget_unconfirmed(self) -> None:
        """Forget the damage since the last valid frame: it has another cause."""
        self._count -= self._unconfirmed
        self._unconfirmed = 0

    def find(self, frame_count: int, now_s: float, reset_count: int = 0) -> Finding | None:
        """Return a finding if too many recent frames are damaged, else None. Called about once a second.

        There were `frame_count` valid frames since the start, and `reset_count` recent resets.
        """
        samples = self._samples
        confirmed = self._count - (self._unconfirmed if frame_count == self._frame_count else 0)
        samples.append((now_s, confirmed, frame_count))
        while len(samples) > 2 and now_s - samples[0][0] > WINDOW_S:
            samples.popleft()
        _, damaged_before, valid_before = samples[0]
        damaged, valid = confirmed - damaged_before, frame_count - valid_before
        if damaged < MIN_DAMAGED + RESET_DAMAGES * reset_count or damaged < MIN_SHARE * (damaged + valid):
            return None
        percent = 100 * damaged / (damaged + valid)
        return warning(
            Code.FRAMES_DAMAGED,
            f"{percent:.2g} % of the frames are damaged ({damaged} of the last {damaged + valid})",
            self._advice,
        )
