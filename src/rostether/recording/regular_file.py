"""Checks that a path is a regular file: opening a FIFO may never return, and devices have no end."""

from __future__ import annotations

import stat
from pathlib import Path

from rostether.errors import RecordingError

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a FIFO"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def require_regular_file(path: Path) -> None:
    """Raise RecordingError if the path exists and is not a file; opening reports a missing file."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    for is_such, kind in _KINDS:
        if is_such(mode):
            raise RecordingError(f"{path} is {kind}, not a file; give a recording or a ROS 2 bag")
