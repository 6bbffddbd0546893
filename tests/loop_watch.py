"""Finds what delays an event loop: long callbacks, and searches of folders."""

from __future__ import annotations

import asyncio
import gc
import sys
import threading
import time
import traceback
import weakref
from asyncio import events

import pytest

from machine_speed import slowness
from rostether.packages import search_path

TIMEOUT_S = 60.0


# Nothing may hold the event loop for this time.
MAX_HELD_S = 0.05


class CallbackWatch:
    """Measures each callback of the event loop in processor time, so that a busy machine does not matter."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._longest_s, self._longest = 0.0, ""
        run = events.Handle._run
        # The objects of the test run would make each garbage collection long.
        gc.collect()
        gc.freeze()

        def run_measured(handle: events.Handle) -> None:
            began_s = time.thread_time()
            run(handle)
            held_s = time.thread_time() - began_s
            if held_s > self._longest_s:
                self._longest_s, self._longest = held_s, repr(handle)

        monkeypatch.setattr(events.Handle, "_run", run_measured)

    def check(self, what: str) -> None:
        """Assert that no callback since the last check was long."""
        longest_s, longest = self._longest_s, self._longest
        self._longest_s, self._longest = 0.0, ""
        if longest_s < MAX_HELD_S:
            return
        slow = slowness()
        assert longest_s < MAX_HELD_S * slow, (
            f"{what} held the loop for {longest_s * 1000:.0f} ms in {longest}, "
            f"on a machine that was {slow:.1f} times as slow as a quiet one"
        )


class FolderWatch:
    """Records each folder that a thread with the event loop `loop` lists."""

    def __init__(self) -> None:
        self.listed: list[str] = []
        """The folders, each with the code that listed it."""
        self._loop = asyncio.get_running_loop()
        _folder_watches.add(self)
        if not _is_hooked:
            # An audit hook cannot be removed; it does nothing without a watch.
            sys.addaudithook(_record_folder)
            _is_hooked.append(True)

    def record(self, path: object) -> None:
        """Record a folder that is being listed."""
        if asyncio._get_running_loop() is not self._loop:
            return
        callers = traceback.extract_stack(limit=12)
        # Imports also list folders.
        if not any("importlib" in each.filename for each in callers):
            own_lines = [
                f"{each.filename}:{each.lineno}" for each in callers if "/rostether/" in each.filename
            ]
            self.listed.append(f"{path} by {own_lines[-1] if own_lines else callers[0]}")


_folder_watches: weakref.WeakSet[FolderWatch] = weakref.WeakSet()
_is_hooked: list[bool] = []


def _record_folder(event: str, args: tuple[object, ...]) -> None:
    if event in ("os.listdir", "os.scandir"):
        for watch in list(_folder_watches):
            watch.record(args[0])


class LoopWatch:
    """Delays each folder of a search until the event loop has run: a slow disk, without a clock."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folders = 0
        """Folders that were read while the loop went on."""
        self.held = 0
        """Folders that were read by the loop's own thread, or while the loop did not run."""
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._list_folder = search_path._list_folder
        monkeypatch.setattr(search_path, "_list_folder", self._list_slowly)

    def _list_slowly(self, path: str, seen: set[tuple[int, int]]) -> tuple[frozenset[str], list[str]] | None:
        loop_ran = threading.Event()
        if threading.get_ident() == self._thread:
            self.held += 1
        else:
            self._loop.call_soon_threadsafe(loop_ran.set)
            if loop_ran.wait(TIMEOUT_S):
                self.folders += 1
            else:
                self.held += 1
        return self._list_folder(path, seen)
