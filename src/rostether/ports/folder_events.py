"""Reports when files appear in a folder or disappear: inotify on Linux, through the C library."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

# <sys/inotify.h>
_IN_NONBLOCK = os.O_NONBLOCK
_IN_CLOEXEC = getattr(os, "O_CLOEXEC", 0)
_IN_MOVED_FROM, _IN_MOVED_TO, _IN_CREATE, _IN_DELETE, _IN_DELETE_SELF = 0x40, 0x80, 0x100, 0x200, 0x400
_IN_ONLYDIR = 0x01000000
_MASK = _IN_MOVED_FROM | _IN_MOVED_TO | _IN_CREATE | _IN_DELETE | _IN_DELETE_SELF | _IN_ONLYDIR
# Room for about a hundred events; the rest is read next time.
_READ_BYTES = 16 * 1024


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
        """Watch all folders, including those that exist again; False while a folder cannot be watched."""
        watched = [
            self._library.inotify_add_watch(self._descriptor, folder, _MASK) >= 0 for folder in self._folders
        ]
        return all(watched)

    def drain(self) -> None:
        """Discard the events so far."""
        try:
            os.read(self._descriptor, _READ_BYTES)
        except BlockingIOError:
            return

    def close(self) -> None:
        """Stop watching."""
        os.close(self._descriptor)
