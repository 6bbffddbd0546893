"""The end of a node: by a signal, the program, the master, or the end of the program."""

from __future__ import annotations

import atexit
import contextlib
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from types import FrameType
from typing import Any


class Shutdown:
    """The state of the shutdown; hooks run once: first those of the program, then those of rospy."""

    def __init__(self) -> None:
        self.event = threading.Event()
        self.is_requested = False
        self._lock = threading.RLock()
        self._client_hooks: list[Callable[[], object]] = []
        self._early_hooks: list[Callable[[str], object]] = []
        self._hooks: list[Callable[[str], object]] = []
        self._previous: dict[int, Any] = {}

    def on_client(self, hook: Callable[[], object]) -> None:
        """Add a hook of the program, which can still publish; during a shutdown, call it immediately.

        Raises TypeError for a hook that cannot be called.
        """
        if not callable(hook):
            raise TypeError(f"shutdown hook [{hook}] must be a function or callable object: {type(hook)}")
        if self.event.is_set():
            hook()
        else:
            self._client_hooks.append(hook)

    def add_early(self, hook: Callable[[str], object]) -> None:
        """Add a hook that gets the reason, after the program's hooks and before the node leaves."""
        self._early_hooks.append(hook)

    def add(self, hook: Callable[[str], object]) -> None:
        """Add a hook that gets the reason, after the node counts as shut down."""
        self._hooks.append(hook)

    def signal(self, reason: str) -> None:
        """End the node, and return after it has left the graph. Idempotent."""
        with self._lock:
            if self.is_requested:
                return
            self.is_requested = True
            for client_hook in self._client_hooks:
                _run(client_hook)
            for hook in self._early_hooks:
                _run(hook, reason)
            self.event.set()
            for hook in self._hooks:
                _run(hook, reason)

    def register_signals(self) -> None:
        """End the node on SIGTERM and SIGINT, and then call the previous handlers."""
        for number in (signal.SIGTERM, signal.SIGINT):
            self._previous[number] = signal.signal(number, self._handle_signal)

    def _handle_signal(self, number: int, frame: FrameType | None) -> None:
        self.signal(f"signal-{number}")
        previous = self._previous.get(number)
        if callable(previous):
            # The program sees is_shutdown() instead.
            with contextlib.suppress(KeyboardInterrupt):
                previous(number, frame)


def _run(hook: Callable[..., object], *arguments: object) -> None:
    try:
        hook(*arguments)
    except BaseException:  # noqa: BLE001 - one hook must not keep the others from running
        traceback.print_exc(file=sys.stderr)


shutdown = Shutdown()
atexit.register(shutdown.signal, "atexit")


def is_shutdown() -> bool:
    """Return whether the node has been shut down."""
    return shutdown.event.is_set()


def is_shutdown_requested() -> bool:
    """Return whether the node is being shut down; hooks may still run."""
    return shutdown.is_requested


def signal_shutdown(reason: str) -> None:
    """Shut the node down."""
    shutdown.signal(reason)


def on_shutdown(h: Callable[[], object]) -> None:
    """Add a function to call at the shutdown, before the node leaves the graph."""
    shutdown.on_client(h)


add_client_shutdown_hook = on_shutdown


def add_preshutdown_hook(h: Callable[[str], object]) -> None:
    """Add a function to call with the reason, after those of `on_shutdown`."""
    shutdown.add_early(h)


def add_shutdown_hook(h: Callable[[str], object]) -> None:
    """Add a function to call with the reason at the shutdown."""
    shutdown.add(h)
