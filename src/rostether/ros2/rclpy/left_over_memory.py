"""Finds shared memory segments of killed programs, for which Fast DDS waits when another program starts."""

from __future__ import annotations

import re
import sys
import time
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")  # noqa: S108 - where Fast DDS puts it

# A running program holds a lock on a file beside each of its segments.
_LOCK_FILE = re.compile(r"fast(?:dds|rtps)_(?:[0-9a-f]{16}|port\d{1,5})_[es]l")

# A program that starts creates the file before it locks it.
_LOCK_DELAY_S = 10.0


def find_leftover_files(folder: Path = SHARED_MEMORY) -> list[str]:
    """Return the names of the segments whose programs have ended, sorted."""
    # Other systems use other locks.
    if sys.platform != "linux":
        return []
    try:
        files = [each for each in folder.iterdir() if _LOCK_FILE.fullmatch(each.name)]
    except OSError:
        return []
    return sorted(each.name[:-3] for each in files if _is_left(each))


def _is_left(file: Path) -> bool:
    import fcntl

    try:
        with file.open("rb") as opened:
            if time.time() - file.stat().st_mtime < _LOCK_DELAY_S:
                return False
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
