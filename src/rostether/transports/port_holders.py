"""Finds other programs that use a serial port or a listening port, as far as Linux shows them."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path

from msgspec import Struct

_PTS = "/dev/pts/"
# State of a listening socket in /proc/net/tcp.
_LISTENING = "0A"
# The number of the driver of /dev/null, /dev/zero and /dev/urandom, which every process may have open.
_MEMORY_MAJOR = 1
# The folders of lock files such as `LCK..ttyUSB0`, in which minicom, gpsd and pppd store their process id.
LOCK_FOLDERS = ("/run/lock", "/var/lock", "/run/lock/lockdev")
# A process id and the name of a program.
_MAX_LOCK_BYTES = 64


class Holder(Struct, frozen=True):
    """A process; `name` is its command, for Python also its script."""

    pid: int
    name: str

    def __str__(self) -> str:
        return f"{self.name} (PID {self.pid})"


def find_holders(path: str) -> list[Holder]:
    """Return the other processes that have a port open, except the creator of a pseudo-terminal."""
    target = os.path.realpath(path)
    holders = []
    for pid in _pids():
        links = _open_files(pid)
        if target in links.values() and not _created_terminal(pid, links, target):
            holders.append(Holder(pid, _name_of(pid)))
    return holders


def is_open_here(path: str) -> bool:
    """Return whether this process has a port open."""
    return os.path.realpath(path) in _open_files(os.getpid()).values()


def find_listener(port: int, *, kind: str = "tcp") -> Holder | None:
    """Return the process that listens on a TCP port, or has bound a UDP port, of this machine."""
    inodes = _socket_inodes(port, kind)
    if not inodes:
        return None
    wanted = {f"socket:[{inode}]" for inode in inodes}
    for pid in _pids():
        if wanted.intersection(_open_files(pid).values()):
            return Holder(pid, _name_of(pid))
    return None


def _pids() -> list[int]:
    try:
        found = [int(entry) for entry in os.listdir("/proc") if entry.isdigit()]  # noqa: PTH208 - only names
    except OSError:
        return []
    return sorted(pid for pid in found if pid != os.getpid())


def _open_files(pid: int) -> dict[str, str]:
    """Return the open files of a process by descriptor; empty if it has ended or belongs to another user."""
    links: dict[str, str] = {}
    try:
        with os.scandir(f"/proc/{pid}/fd") as entries:
            for entry in entries:
                try:
                    links[entry.name] = os.readlink(entry.path)  # noqa: PTH115 - Paths would take seconds
                except OSError:
                    continue
    except OSError:
        pass
    return links


def _created_terminal(pid: int, links: dict[str, str], target: str) -> bool:
    """Return whether a process has the other end of a pseudo-terminal: a simulator that created it."""
    if not target.startswith(_PTS):
        return False
    index = target.removeprefix(_PTS)
    for descriptor, link in links.items():
        if link.endswith("ptmx"):
            try:
                info = Path(f"/proc/{pid}/fdinfo/{descriptor}").read_text(encoding="ascii", errors="replace")
            except OSError:
                continue
            if f"tty-index:\t{index}\n" in info:
                return True
    return False


def _name_of(pid: int) -> str:
    try:
        name = Path(f"/proc/{pid}/comm").read_text(encoding="utf-8", errors="replace").strip()
        words = Path(f"/proc/{pid}/cmdline").read_bytes().decode("utf-8", "replace").split("\0")
    except OSError:
        return "a process"
    if name.startswith("python") and len(words) > 2:
        script = words[2] if words[1] == "-m" else words[1]
        # The argument of `-c` is a program's text.
        return name if script.startswith("-") else f"{name} {Path(script).name}"
    return name


def _socket_inodes(port: int, kind: str) -> set[str]:
    inodes = set()
    for table in (f"/proc/net/{kind}", f"/proc/net/{kind}6"):
        try:
            lines = Path(table).read_text(encoding="ascii", errors="replace").splitlines()[1:]
        except OSError:
            continue
        for line in lines:
            columns = line.split()
            is_bound = kind == "udp" or columns[3] == _LISTENING
            if is_bound and int(columns[1].rpartition(":")[2], 16) == port:
                inodes.add(columns[9])
    return inodes


def is_character_device(path: str) -> bool:
    """Return whether a path is a device file, as serial ports are, and not /dev/null or a similar one."""
    try:
        status = Path(path).stat()
    except OSError:
        return False
    is_memory = sys.platform == "linux" and os.major(status.st_rdev) == _MEMORY_MAJOR
    return stat.S_ISCHR(status.st_mode) and not is_memory


def find_port_user(path: str) -> str | None:
    """Return the program that uses a port, None if no program is found. Reading /proc takes some time.

    Discovery asks this before it opens a port. Trying to open it is not enough: many programs set no lock,
    and root can open a port in spite of a lock.
    """
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
