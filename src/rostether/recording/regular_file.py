"""Whether a path is a file as recordings are: opening a FIFO waits for ever, and devices have no end."""

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
    """Raise RecordingError for what is there and no file; what is missing is told by who opens it."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    for is_such, kind in _KINDS:
        if is_such(mode):
            raise RecordingError(f"{path} is {kind}, not a file; name a recording's file, or a ROS 2 bag")
