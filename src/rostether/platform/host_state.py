"""The clock and the free disk space of this machine, for a robot's status."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from rostether.platform.status_frame import HostState


def read_host(folder: Path = Path()) -> HostState:
    """Return the state now; the disk is that of `folder`. A folder that was removed has no free space."""
    try:
        free_bytes = shutil.disk_usage(folder).free
    except OSError:
        free_bytes = 0
    return HostState(time.time_ns() // 1000, free_bytes)
