"""Stores the last baud rate of each board, so that it need not be detected again."""

from __future__ import annotations

import contextlib
from pathlib import Path

from rostether.mechanisms.state_file import load_state, store_state
from rostether.transports.address_parser import MAX_BAUD

# Enough for a workshop; the boards that were seen least recently are removed, and detected again on return.
MAX_BOARDS = 500
# About 500 bytes for each board, more than a line with the longest key.
MAX_FILE_BYTES = 256 * 1024


class KnownBoards:
    """Baud rates by board, stored in a file (`path`; None: in memory only).

    An unreadable file counts as empty, because the rates can be detected again.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._bauds = _read(path) if path is not None else {}

    def baud_of(self, key: str) -> int | None:
        """Return the baud rate of a board, by its identity's key."""
        return self._bauds.get(key)

    def remember(self, key: str, baud: int) -> None:
        """Store a board's baud rate; the file is written only if it has changed."""
        has_changed = self._bauds.pop(key, None) != baud
        self._bauds[key] = baud
        while len(self._bauds) > MAX_BOARDS:
            self._bauds.pop(next(iter(self._bauds)))
        if has_changed and self._path is not None:
            # If the folder cannot be written, the rate is detected again next time.
            with contextlib.suppress(OSError):
                store_state(self._path, {"bauds": self._bauds})


def _read(path: Path) -> dict[str, int]:
    bauds = load_state(path, MAX_FILE_BYTES).get("bauds")
    if not isinstance(bauds, dict):
        return {}
    return {
        key: baud
        for key, baud in list(bauds.items())[-MAX_BOARDS:]
        if isinstance(baud, int) and not isinstance(baud, bool) and 0 < baud <= MAX_BAUD
    }
