"""Detects when serial ports appear and disappear, without querying the system's list all the time.

On Linux a port is a file, and the kernel reports when one appears in a folder or disappears. On other
systems, each folder is checked four times a second, which costs one `stat`. The list itself is queried after
a folder has changed, several times, because the system sets a new port's serial number and permissions a
moment later. It is also queried at a low rate without changes.
"""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Self

from rostether.mechanisms.tasks import occurs_within
from rostether.ports.port_pattern import is_port_pattern, named_ports
from rostether.transports.port_holders import is_character_device
from rostether.transports.serial_port import ListPorts, SerialPort, find_usb_location

# How soon a board is noticed on systems without notifications; one check takes about 0.2 ms.
CHECK_PERIOD_S = 0.25

# After a change, every check queries the list: udev needs up to a second on small computers.
SETTLING_S = 2.0

# The interval without visible changes; querying the list takes 2 ms.
LIST_PERIOD_S = 60.0

# The interval on systems where ports are not files (Windows), or where folders may not show changes (macOS).
BLIND_LIST_PERIOD_S = 2.0

DEVICE_FOLDER = "/dev"
_REPORTS_CHANGES = sys.platform == "linux"

# <sys/inotify.h>
_IN_NONBLOCK = os.O_NONBLOCK
_IN_CLOEXEC = getattr(os, "O_CLOEXEC", 0)
_IN_MOVED_FROM, _IN_MOVED_TO, _IN_CREATE, _IN_DELETE, _IN_DELETE_SELF = 0x40, 0x80, 0x100, 0x200, 0x400
_IN_ONLYDIR = 0x01000000
_MASK = _IN_MOVED_FROM | _IN_MOVED_TO | _IN_CREATE | _IN_DELETE | _IN_DELETE_SELF | _IN_ONLYDIR
# Room for about a hundred events; the rest is read next time.
_READ_BYTES = 16 * 1024


class PortWatch:
    """Watches the ports of this machine and those that `entries` name.

    `list_ports` is the system's list, `folders` are where its ports appear.
    """

    def __init__(
        self,
        list_ports: ListPorts,
        *,
        entries: Iterable[str] = (),
        folders: Sequence[str] = (DEVICE_FOLDER,),
        period_s: float = CHECK_PERIOD_S,
    ) -> None:
        self._list_ports = list_ports
        self._entries = tuple(entry for entry in entries if is_port_pattern(entry))
        named = {str(Path(entry).parent) for entry in self._entries if "/" in entry}
        self._folders = tuple(dict.fromkeys((*folders, *sorted(named))))
        self._period_s = period_s

    async def changes(self) -> AsyncIterator[list[SerialPort]]:
        """Yield the current ports, and again after each change."""
        known: list[SerialPort] | None = None
        with _ChangeSignal(self._folders) as alarm:
            async for _ in self._reasons(alarm):
                ports: list[SerialPort] | None
                try:
                    ports = self.list()
                except OSError:
                    # A port disappeared while the system was describing it; the next list has the others.
                    ports = known
                if ports is not None and ports != known:
                    known = ports
                    yield ports

    async def _reasons(self, alarm: _ChangeSignal) -> AsyncIterator[None]:
        """Yield each time the list must be queried."""
        clock = asyncio.get_running_loop().time
        marks: list[int] | None = None
        settled_s = listed_s = float("-inf")
        while True:
            is_armed = alarm.arm()
            now_s = clock()
            fresh = [folder_mark(folder) for folder in self._folders]
            if fresh != marks or alarm.read_and_clear():
                marks, settled_s = fresh, now_s + SETTLING_S
            list_period_s = LIST_PERIOD_S if _REPORTS_CHANGES and any(marks) else BLIND_LIST_PERIOD_S
            is_settling = now_s < settled_s
            if is_settling or now_s - listed_s >= list_period_s:
                listed_s = now_s
                yield
            if is_armed and not is_settling:
                await alarm.wait(list_period_s)
            else:
                # The list is queried at most four times a second, regardless of the number of new files.
                await asyncio.sleep(self._period_s)

    def list(self) -> list[SerialPort]:
        """Return the current ports."""
        ports = list(self._list_ports())
        real_paths = {os.path.realpath(port.path) for port in ports}
        for path in named_ports(self._entries):
            real_path = os.path.realpath(path)
            if real_path not in real_paths and is_character_device(real_path):
                real_paths.add(real_path)
                location = find_usb_location(real_path)
                ports.append(SerialPort(path, "named in your settings", usb_location=location))
        return ports


def folder_mark(folder: str) -> int:
    """Return a value that changes when a file appears in a folder or disappears; 0 for a missing folder."""
    try:
        return os.stat(folder).st_mtime_ns  # noqa: PTH116 - four times a second
    except OSError:
        return 0


class _ChangeSignal:
    """Ends a wait when a folder changes, if the system reports changes."""

    def __init__(self, folders: Sequence[str]) -> None:
        self._folders = folders
        self._events: FolderEvents | None = None
        self._changed = asyncio.Event()
        self._has_changed = False

    def __enter__(self) -> Self:
        try:
            self._events = FolderEvents(self._folders)
            asyncio.get_running_loop().add_reader(self._events.fileno(), self._note_change)
        except (OSError, AttributeError, NotImplementedError):
            # inotify is missing, or its limit per user is reached.
            self._stop()
        return self

    def __exit__(self, *_error: object) -> None:
        if self._events is not None:
            asyncio.get_running_loop().remove_reader(self._events.fileno())
        self._stop()

    def arm(self) -> bool:
        """Start to watch; return False if that is not possible now, and the caller must poll."""
        return self._events is not None and self._events.watch()

    def read_and_clear(self) -> bool:
        """Return whether a folder has changed since the last call."""
        has_changed, self._has_changed = self._has_changed, False
        return has_changed

    async def wait(self, limit_s: float) -> None:
        """Wait until a folder changes or the time limit passes."""
        if not self._has_changed:
            self._changed.clear()
            await occurs_within(self._changed, limit_s)

    def _note_change(self) -> None:
        if self._events is not None:
            self._events.drain()
        self._has_changed = True
        self._changed.set()

    def _stop(self) -> None:
        events, self._events = self._events, None
        if events is not None:
            events.close()


class FolderEvents:
    """Events of folders; `fileno` is readable when there are any. Raises OSError without inotify."""

    def __init__(self, folders: Sequence[str]) -> None:
        if sys.platform != "linux":
            raise OSError("inotify exists only on Linux")
        # Imported late: most bridges have fixed ports and watch no folder.
        import ctypes

        self._folders = [os.fsencode(folder) for folder in folders]
        self._library = ctypes.CDLL(None, use_errno=True)
        self._descriptor: int = self._library.inotify_init1(_IN_NONBLOCK | _IN_CLOEXEC)
        if self._descriptor < 0:
            raise OSError(ctypes.get_errno(), "inotify_init1")

    def fileno(self) -> int:
        """Return the descriptor to wait for."""
        return self._descriptor

    def watch(self) -> bool:
        """Watch all folders, including those that were created again; return whether all can be watched."""
        watched = [
            self._library.inotify_add_watch(self._descriptor, folder, _MASK) >= 0 for folder in self._folders
        ]
        return all(watched)

    def drain(self) -> None:
        """Discard the events so far."""
        with suppress(BlockingIOError):
            os.read(self._descriptor, _READ_BYTES)

    def close(self) -> None:
        """Stop watching."""
        os.close(self._descriptor)
