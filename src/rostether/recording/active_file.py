"""A recording's file gets another name, and what belongs to it goes with it."""

from __future__ import annotations

import contextlib
from pathlib import Path

# What SQLite leaves beside a file that found no room to be closed: the file is nothing without it.
_LOG_SUFFIXES = ("-wal", "-shm", "-journal")


def end_active(active: Path, path: Path) -> None:
    """Let `active` become `path`, over one that is there, with the logs of both. Raises OSError."""
    active.replace(path)
    if path.suffix != ".db3":
        return
    for suffix in _LOG_SUFFIXES:
        log = path.with_name(path.name + suffix)
        log.unlink(missing_ok=True)
        with contextlib.suppress(FileNotFoundError):
            active.with_name(active.name + suffix).replace(log)
