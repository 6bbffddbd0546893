"""The link that gives a pseudo-terminal a lasting name."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from rostether.errors import TransportOpenError
from rostether.transports.serial_errors import is_pseudo_terminal


class PtyLink:
    """The link at a path to a pseudo-terminal; without a path, nothing is linked.

    Raises TransportOpenError if the link would replace a file of the user.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._terminal: str | None = None
        if path is None:
            return
        if path.is_symlink():
            if path.exists() and not is_pseudo_terminal(str(path)):
                raise TransportOpenError(f"{path} is a link to something else; choose another path for pty:")
        elif path.exists():
            raise TransportOpenError(f"{path} already exists; remove it, or choose another path for pty:")

    def place(self, terminal: str) -> None:
        """Create the link atomically: a program that waits for the path never finds a wrong one."""
        if self.path is None:
            return
        fresh = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        fresh.unlink(missing_ok=True)
        fresh.symlink_to(terminal)
        try:
            fresh.replace(self.path)
        except OSError:
            fresh.unlink(missing_ok=True)
            raise
        self._terminal = terminal

    def remove(self) -> None:
        """Remove the link unless it now points to another terminal. Idempotent."""
        if self.path is None or self._terminal is None:
            return
        with contextlib.suppress(OSError):
            if str(self.path.readlink()) == self._terminal:
                self.path.unlink()
        self._terminal = None
