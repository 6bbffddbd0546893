"""At which speed each board answered last time, so that it need not be searched for again."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path

from rostether.transports.address import MAX_BAUD

# A workshop's worth of boards; the longest unseen are forgotten, and searched for again when they come.
MAX_BOARDS = 500
MAX_FILE_BYTES = 256 * 1024
_FORMAT = 1


class KnownBoards:
    """Speeds by board, kept in a file (`path`; None: in memory only).

    A file that cannot be read is as none: what it holds can be found out again.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._bauds = _read(path) if path is not None else {}

    def baud_of(self, key: str) -> int | None:
        """Return the speed of a board, by its identity's key."""
        return self._bauds.get(key)

    def remember(self, key: str, baud: int) -> None:
        """Record a board's speed; the file is written only if it changed."""
        is_news = self._bauds.pop(key, None) != baud
        self._bauds[key] = baud
        while len(self._bauds) > MAX_BOARDS:
            self._bauds.pop(next(iter(self._bauds)))
        if is_news and self._path is not None:
            # A folder that cannot be written costs a search next time, and nothing now.
            with contextlib.suppress(OSError):
                _write(self._path, self._bauds)


def _read(path: Path) -> dict[str, int]:
    try:
        with path.open("rb") as file:
            content = json.loads(file.read(MAX_FILE_BYTES))
    except (OSError, ValueError, RecursionError):
        return {}
    bauds = content.get("bauds") if isinstance(content, dict) and content.get("format") == _FORMAT else None
    if not isinstance(bauds, dict):
        return {}
    return {
        key: baud
        for key, baud in list(bauds.items())[-MAX_BOARDS:]
        if isinstance(baud, int) and not isinstance(baud, bool) and 0 < baud <= MAX_BAUD
    }


def _write(path: Path, bauds: dict[str, int]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    fresh.write_text(json.dumps({"format": _FORMAT, "bauds": bauds}, indent=1) + "\n", encoding="utf-8")
    fresh.replace(path)
