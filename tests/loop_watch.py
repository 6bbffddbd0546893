"""Finds what holds up an event loop: long callbacks, and searches of folders."""

from __future__ import annotations

import asyncio
import gc
import threading
import time
from asyncio import events

import pytest

from rostether.packages import search_path

CEILING_S = 60.0


# "Nothing holds the event loop for 50 ms."
MAX_HELD_S = 0.05


class CallbackWatch:
    """Measures each callback of the event loop in processor time, so that a busy machine does not matter."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._longest_s, self._longest = 0.0, ""
        run = events.Handle._run
        # The objects of the test run itself would make each garbage collection long.
        gc.collect()
        gc.freeze()

        def run_measured(handle: events.Handle) -> None:
            label = repr(handle)
            began_s = time.thread_time()
            run(handle)
            held_s = time.thread_time() - began_s
            if held_s > self._longest_s:
                self._longest_s, self._longest = held_s, label

        monkeypatch.setattr(events.Handle, "_run", run_measured)

    def check(self, what: str) -> None:
        """Assert that no callback since the last check was long."""
        longest_s, longest = self._longest_s, self._longest
        self._longest_s, self._longest = 0.0, ""
        assert longest_s < MAX_HELD_S, f"{what} held the loop for {longest_s * 1000:.0f} ms in {longest}"


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
