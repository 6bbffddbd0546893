"""Says why a board does not answer, from what came instead."""

from __future__ import annotations

from rostether.bridge.reporter import Notices
from rostether.graph.ports import Level
from rostether.rosserial.events import DeviceSilent, FrameDiscarded

# What of the noise is kept to show: a line of a sketch's own Serial.print.
SHOWN_BYTES = 60


class SyncReport:
    """Watches one session's line for valid frames; `baud` is its speed where it has one."""

    def __init__(self, notices: Notices, baud: int | None) -> None:
        self._notices = notices
        self._baud = baud
        self._was_alive = False
        self._noise = bytearray()
        self._noise_bytes = 0

    def alive(self) -> None:
        """A frame came that only a rosserial board sends."""
        self._was_alive = True
        self._noise.clear()
        self._noise_bytes = 0
        self._notices.end_episode("silent")

    def discarded(self, event: FrameDiscarded) -> None:
        """Bytes came that were not believed."""
        self._noise_bytes += len(event.data)
        self._noise += event.data[: SHOWN_BYTES - len(self._noise)]

    def silent(self, event: DeviceSilent) -> None:
        """Nothing valid came for longer than a healthy board is silent."""
        self._notices.episode("silent", Level.WARN, lambda: self._explain(event.silence_s))
        self._noise.clear()
        self._noise_bytes = 0

    def _explain(self, silence_s: float) -> str:
        if self._noise_bytes:
            hint = f" or a baud rate other than {self._baud}" if self._baud else ""
            return (
                f"no rosserial frame for {silence_s:.0f} s, but {self._noise_bytes} other bytes "
                f"({_show(bytes(self._noise))}): text that the sketch prints on this port{hint}"
            )
        if self._was_alive:
            return f"the board has been silent for {silence_s:.0f} s; asking for its topics until it answers"
        hint = f", and whether its baud rate is {self._baud}" if self._baud else ""
        return (
            f"no answer from the board for {silence_s:.0f} s; check that its sketch runs rosserial on this "
            f"port{hint}"
        )


def _show(noise: bytes) -> str:
    text = noise.decode("ascii", "replace")
    printable = sum(char.isprintable() or char.isspace() for char in text.replace("\ufffd", ""))
    if noise and printable * 10 >= len(noise) * 9:
        return repr(text)
    return noise[:16].hex(" ")
