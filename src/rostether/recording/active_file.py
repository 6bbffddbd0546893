"""Renames a finished recording and its SQLite log files."""

from __future__ import annotations

import contextlib
from pathlib import Path

# The log files that SQLite leaves if the disk is full at the end; the database is incomplete without them.
_LOG_SUFFIXES = ("-wal", "-shm", "-journal")


def end_active(active: Path, path: Path) -> None:
    """Rename `active` and its log files to `path`, replacing existing ones. Raises OSError."""
    active.replace(path)
    if path.suffix != ".db3":
        return
    for suffix in _LOG_SUFFIXES:
        log = path.with_name(path.name + suffix)
        log.unlink(missing_ok=True)
        with contextlib.suppress(FileNotFoundError):
            active.with_name(active.name + suffix).replace(log)
