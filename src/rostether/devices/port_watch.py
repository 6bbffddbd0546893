"""Notices when serial ports come and go, without asking the system for its list all the time.

On Linux a port is a file: while the folders that hold them are as they were, one `stat` each is all that a
look costs. The list itself is made when they changed, some times after that, since the system
fills in a new port's serial number and permissions a moment later, and now and then anyway.
"""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from pathlib import Path

from rostether.devices.port_pattern import is_port_pattern, named_ports
from rostether.transports.serial_port import SerialPort, find_usb_location

LOOK_PERIOD_S = 0.25
"""A board is noticed within this; a look takes 10 us, so that the CPU is idle for 99.99 % of the time."""

SETTLING_S = 2.0
"""After a change, every look makes the list: udev needs up to a second on small computers."""

LIST_PERIOD_S = 60.0
"""Nothing changed that we could see; a list takes 2 ms."""

BLIND_LIST_PERIOD_S = 2.0
"""Where ports are no files (Windows), or their folder may not tell (macOS), only the list itself does."""

DEVICE_FOLDER = "/dev"
_FOLDERS_TELL = sys.platform == "linux"

ListPorts = Callable[[], Sequence[SerialPort]]


class PortWatch:
    """Watches the ports of this machine and those that `entries` name, wherever these are.

    `list_ports` is the system's list, `folders` are where its ports appear.
    """

    def __init__(
        self,
        list_ports: ListPorts,
        *,
        entries: Iterable[str] = (),
        folders: Sequence[str] = (DEVICE_FOLDER,),
        period_s: float = LOOK_PERIOD_S,
    ) -> None:
        self._list_ports = list_ports
        self._entries = tuple(entry for entry in entries if is_port_pattern(entry))
        named = {str(Path(entry).parent) for entry in self._entries if "/" in entry}
        self._folders = tuple(dict.fromkeys((*folders, *sorted(named))))
        self._period_s = period_s
        self.list_count = 0

    async def changes(self) -> AsyncIterator[list[SerialPort]]:
        """Yield the ports that are there now, and again whenever something about them changed."""
        clock = asyncio.get_running_loop().time
        known: list[SerialPort] | None = None
        marks: list[int] | None = None
        settled_s = listed_s = float("-inf")
        while True:
            now_s = clock()
            fresh = [folder_mark(folder) for folder in self._folders]
            if fresh != marks:
                marks, settled_s = fresh, now_s + SETTLING_S
            period_s = LIST_PERIOD_S if _FOLDERS_TELL and any(marks) else BLIND_LIST_PERIOD_S
            if now_s < settled_s or now_s - listed_s >= period_s:
                listed_s = now_s
                ports: list[SerialPort] | None
                try:
                    ports = self.list()
                except OSError:
                    # A port went away while the system was describing it; the next look has the rest.
                    ports = known
                if ports is not None and ports != known:
                    known = ports
                    yield ports
            await asyncio.sleep(self._period_s)

    def list(self) -> list[SerialPort]:
        """Return the ports that are there now."""
        self.list_count += 1
        ports = list(self._list_ports())
        real_paths = {os.path.realpath(port.path) for port in ports}
        for path in named_ports(self._entries):
            real_path = os.path.realpath(path)
            if real_path not in real_paths and _is_terminal(real_path):
                real_paths.add(real_path)
                location = find_usb_location(real_path)
                ports.append(SerialPort(path, "named in your settings", usb_location=location))
        return ports


def folder_mark(folder: str) -> int:
    """Return what changes when a file appears in a folder or goes; 0 for a folder that is not there."""
    try:
        return os.stat(folder).st_mtime_ns  # noqa: PTH116 - four times a second
    except OSError:
        return 0


def _is_terminal(path: str) -> bool:
    try:
        return Path(path).is_char_device()
    except OSError:
        return False
