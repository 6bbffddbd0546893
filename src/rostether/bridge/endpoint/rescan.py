"""Searches accepted messages for frames: noise that passes the checksum covers the frames after it."""

from __future__ import annotations

from collections.abc import Callable

from rostether.rosserial.events import HostEvent
from rostether.rosserial.host_link import HostLink

# Nested searches. Noise within noise passes its checksum once in 65,536 times, and a board that sends only
# noise makes the scanner read each byte that many more times.
MAX_DEPTH = 2


class Rescan:
    """Scans messages that do not have their type's layout, and handles the frames in them."""

    def __init__(self, link: HostLink, handle: Callable[[HostEvent], None]) -> None:
        self._link = link
        self._handle = handle
        self._depth = 0

    def rescan(self, payload: bytes, now_s: float) -> None:
        """Handle the frames in a payload."""
        if self._depth >= MAX_DEPTH:
            return
        self._depth += 1
        try:
            for event in self._link.rescan(payload, now_s):
                self._handle(event)
        finally:
            self._depth -= 1
