"""Checks whether another program uses a serial port, before a port is opened automatically.

Trying to open it is not enough: many programs set no lock, and root can open a port in spite of a lock.
"""

from __future__ import annotations

import os
from pathlib import Path

from rostether.transports.port_holders import find_holders

# The folders of lock files such as `LCK..ttyUSB0`, in which minicom, gpsd and pppd store their process id.
LOCK_FOLDERS = ("/run/lock", "/var/lock", "/run/lock/lockdev")
# A process id and the name of a program.
_MAX_LOCK_BYTES = 64


def find_port_user(path: str) -> str | None:
    """Return the program that uses a port, None if no program is found. Reading /proc takes some time."""
    for holder in find_holders(path):
        return str(holder)
    for folder in LOCK_FOLDERS:
        for name in {path, os.path.realpath(path)}:
            pid = _read_lock(Path(folder) / f"LCK..{name.rpartition('/')[2]}")
            if pid is not None and pid != os.getpid() and _is_running(pid):
                return f"the program with PID {pid} (from its lock file)"
    return None


def _read_lock(path: Path) -> int | None:
    try:
        with path.open("rb") as file:
            data = file.read(_MAX_LOCK_BYTES)
    except OSError:
        return None
    # Text according to the standard, or four bytes from some old programs.
    text = data.strip(b" \t\r\n\0")
    if text[:10].split(b" ")[0].isdigit():
        return int(text[:10].split(b" ")[0])
    return int.from_bytes(data, "little") if len(data) == 4 else None


def _is_running(pid: int) -> bool:
    if pid <= 0:
        return False
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True  # another user's
    return True
