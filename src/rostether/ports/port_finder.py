"""Finds the current port of a board, which may return under another number."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from rostether.ports.board_identity import BoardIdentity
from rostether.ports.port_policy import identify
from rostether.ports.port_watch import SETTLING_S, ListPorts, folder_mark


class PortFinder:
    """Finds the board that was last seen at `path`; at first, any board at `path`."""

    def __init__(self, path: str, list_ports: ListPorts, clock: Callable[[], float]) -> None:
        self._path = path
        self._list_ports = list_ports
        self._clock = clock
        self._identity: BoardIdentity | None = None
        self._mark: int | None = None
        self._lists_until_s = float("-inf")
        self._elsewhere: str | None = None

    def identify(self, path: str) -> BoardIdentity:
        """Return the identity of the board at a path, and search for this board from now on."""
        real_path = os.path.realpath(path)
        for port in self._list_ports():
            if port.path == real_path:
                found = identify(port)
                if found.own_serial_number is not None or found.usb_location is not None:
                    self._identity = found
                return replace(found, port=path)
        return BoardIdentity(port=path)

    def find(self) -> str | None:
        """Return the board's current path, None while it is unplugged; a call takes about 10 µs."""
        if self._identity is not None and (path := self._find_elsewhere(self._identity)) is not None:
            return path
        return self._path if Path(self._path).exists() else None

    def _find_elsewhere(self, identity: BoardIdentity) -> str | None:
        """Return the path of the known board if it is not at the usual path."""
        now_s, mark = self._clock(), folder_mark(str(Path(identity.port or self._path).parent))
        if mark != self._mark:
            self._mark, self._lists_until_s = mark, now_s + SETTLING_S
        if now_s < self._lists_until_s:
            here = os.path.realpath(self._path)
            self._elsewhere = None
            for port in self._list_ports():
                if port.path != here and identify(port).key == identity.key:
                    self._elsewhere = port.path
        return self._elsewhere if self._elsewhere and Path(self._elsewhere).exists() else None
