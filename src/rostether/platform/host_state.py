"""The state of a robot's computer in its status: the clock, the free disk space and the Wi-Fi signal."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from rostether.platform.status_frame import HostState

# proc(5), "Wireless Extensions".
_WIRELESS = Path("/proc/net/wireless")
# One line for each interface; a robot has one or two.
_MAX_LINES = 64


def read_host(folder: Path = Path()) -> HostState:
    """Return the state now; the disk is that of `folder`. A folder that was removed has no free space."""
    try:
        free_bytes = shutil.disk_usage(folder).free
    except OSError:
        free_bytes = 0
    return HostState(time.time_ns() // 1000, free_bytes)


def read_signal_dbm(interfaces: tuple[str, ...] = (), path: Path = _WIRELESS) -> int | None:
    """Return the signal in dBm of the first wireless interface among `interfaces`, None if there is none.

    Without names, all interfaces are searched. Only Linux has the file.
    """
    try:
        lines = path.read_text(encoding="ascii", errors="replace").splitlines()[2:_MAX_LINES]
    except OSError:
        return None
    for line in lines:
        name, _, values = line.partition(":")
        words = values.split()
        if len(words) >= 3 and (not interfaces or name.strip() in interfaces):
            try:
                signal = int(float(words[2]))
            except ValueError:
                continue
            # Some drivers report 0 to 255 for -256 to -1.
            return signal - 256 if signal > 63 else signal
    return None
