"""Detects the protocol version of a device from its first frames.

Both versions are decoded until one of them yields a plausible frame. Version 2 has a header checksum, so each
of its frames counts. Version 1 has none, so only a control packet with its exact layout counts. Noise in one
version may be a frame in the other, so noise is reported only after the detection, or after a delay.
"""

from __future__ import annotations

from collections.abc import Container

from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame_decoder import NO_LIMITS, Decoded, FrameDecoder, Frames, PayloadLimits
from rostether.rosserial.packets import TIME_BYTES, Log, ParameterRequest, TopicInfo

# An announcement takes 0.1 s at 9600 baud; text that a board prints is shown after this delay at most.
HOLD_NOISE_S = 0.25

# The number of delayed stretches of noise; further ones are reported immediately.
MAX_HELD = 256


class ProtocolDetector:
    """Replaces a FrameDecoder until `decoder` is known."""

    def __init__(self, *, max_payload_bytes: int, limits: PayloadLimits = NO_LIMITS) -> None:
        self.decoder: FrameDecoder | None = None
        self._candidates = {
            version: FrameDecoder(version, max_payload_bytes=max_payload_bytes, limits=limits)
            for version in (2, 1)
        }
        self._held: dict[int, list[Decoded]] = {version: [] for version in self._candidates}
        self._release_s: float | None = None

    def is_receiving(self, topic_ids: Container[int], now_s: float) -> bool:
        """Return whether a frame of these ids is being received; False while the version is unknown."""
        return False

    def use_limits(self, limits: PayloadLimits) -> None:
        """Apply these limits, starting with the next frame."""
        for reader in self._candidates.values():
            reader.use_limits(limits)

    def feed(self, data: bytes | bytearray | memoryview, now_s: float) -> list[Decoded]:
        """Handle a chunk; return nothing until the version is known, or noise has waited long enough."""
        return self._detect(
            {version: reader.feed(data, now_s) for version, reader in self._candidates.items()}, now_s
        )

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, None if nothing is scheduled."""
        timers = [reader.get_timer() for reader in self._candidates.values()]
        return min((timer for timer in (*timers, self._release_s) if timer is not None), default=None)

    def handle_timer(self, now_s: float) -> list[Decoded]:
        """Search unfinished frames, and report noise that has waited long enough."""
        decoded = self._detect(
            {version: reader.handle_timer(now_s) for version, reader in self._candidates.items()}, now_s
        )
        if self._release_s is not None and now_s >= self._release_s:
            decoded += self._release()
        return decoded

    def abandon(self, now_s: float) -> list[Decoded]:
        """Stop waiting; return the remaining events, as version 2 reads them."""
        return self._release() + self._candidates[2].abandon(now_s)

    def _detect(self, found: dict[int, list[Decoded]], now_s: float) -> list[Decoded]:
        for version, decoded in found.items():
            if any(isinstance(item, Frames) and _is_plausible(version, item) for item in decoded):
                self.decoder = self._candidates[version]
                self._release_s = None
                return self._held[version] + decoded
            self._held[version] += [item for item in decoded if isinstance(item, FrameDiscarded)]
        if self._release_s is None and any(self._held.values()):
            self._release_s = now_s + HOLD_NOISE_S
        return self._release() if len(self._held[2]) > MAX_HELD or len(self._held[1]) > MAX_HELD else []

    def _release(self) -> list[Decoded]:
        released = self._held[2]
        self._held = {version: [] for version in self._candidates}
        self._release_s = None
        return released


def _is_plausible(version: int, frames: Frames) -> bool:
    payload = frames.payloads[0]
    if frames.topic_id in ids.ANNOUNCEMENTS:
        return TopicInfo.decode(payload) is not None
    if frames.topic_id == ids.TIME:
        return len(payload) == TIME_BYTES or (version == 2 and not payload)
    if frames.topic_id == ids.LOG:
        return Log.decode(payload) is not None
    if frames.topic_id == ids.PARAMETER:
        return ParameterRequest.decode(payload) is not None
    return version == 2 and frames.topic_id >= ids.FIRST_USER_ID
