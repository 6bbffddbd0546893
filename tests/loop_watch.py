"""Finds searches of folders that hold up an event loop."""

from __future__ import annotations

import asyncio
import threading

import pytest

from rostether.packages import search_path

CEILING_S = 60.0


class LoopWatch:
    """Lets each folder of a search wait until the event loop has gone round: a slow disk, without a clock."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folders = 0
        """Folders that were read while the loop went on."""
        self.held = 0
        """Folders that were read by the loop's own thread, or while it did not move."""
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._list_folder = search_path._list_folder
        monkeypatch.setattr(search_path, "_list_folder", self._list_slowly)

    def _list_slowly(self, path: str, seen: set[tuple[int, int]]) -> tuple[frozenset[str], list[str]] | None:
        went_round = threading.Event()
        if threading.get_ident() == self._thread:
            self.held += 1
        else:
            self._loop.call_soon_threadsafe(went_round.set)
            if went_round.wait(CEILING_S):
                self.folders += 1
            else:
                self.held += 1
        return self._list_folder(path, seen)
