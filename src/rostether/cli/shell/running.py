"""Runs a command's coroutine to a clean end, on any request to stop.

Ctrl-C and SIGTERM cancel the command, which then leaves the graph; a second Ctrl-C does not wait for that. A
command that computes without an `await` is interrupted, and leaves the graph too; one that still reads its
files, before its first `await`, ends immediately. Like rospy's nodes, and unlike most programs, a command
handles SIGINT even if a shell started it in the background with SIGINT ignored: `command & ... kill -INT $!`
is how scripts stop ROS programs.
"""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import os
import signal
import socket
import time
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

import click

from rostether.cli.shell.failures import EXIT_DONE, EXIT_INTERRUPTED
from rostether.cli.shell.interrupts import note_interrupt, was_interrupted
from rostether.cli.shell.library_logs import show_library_logs
from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.transports.descriptors import allow_many_descriptors

T = TypeVar("T")

# A signal interrupts a loop that is busy for this long; a step of more than 50 ms is already a defect.
BUSY_S = 2.0

# `timeout -s INT` signals a command and then its group: a user does not press Ctrl-C twice so quickly.
SAME_SIGNAL_S = 0.25

# The exit code that a shell reports for a program that SIGTERM ended.
EXIT_TERMINATED = 143


def run(main: Coroutine[Any, Any, T], *, is_service: bool = False, uvloop: bool | None = False) -> T:
    """Run a command and return its result. `uvloop`: True requires it, None uses it when it is installed.

    Ctrl-C raises click's Exit with 130, and SIGTERM with 143, or with 0 if `is_service`. Raises ConfigError
    if uvloop is required and not installed.
    """
    show_library_logs()
    if is_service:
        allow_many_descriptors()
    try:
        loop_factory = _loop_factory(uvloop)
    except ConfigError:
        main.close()
        raise
    ending = _Ending(EXIT_DONE if is_service else EXIT_TERMINATED)
    ending.watch_start()
    try:
        with asyncio.Runner(loop_factory=loop_factory) as runner:
            result = runner.run(ending.run(notifying_systemd(main) if is_service else main))
    except (KeyboardInterrupt, asyncio.CancelledError):
        # Without an exit code, Ctrl-C came before `_Ending` had set its handlers, and asyncio handled it.
        raise click.exceptions.Exit(
            EXIT_INTERRUPTED if ending.exit_code is None else ending.exit_code
        ) from None
    else:
        if ending.exit_code is not None:
            # The signal came too late to end this part of the command, so it ends the next part.
            note_interrupt()
        return result
    finally:
        ending.stop()


class _Ending:
    """Ends a command at a signal: cancels it, or interrupts it while it computes without an `await`."""

    def __init__(self, terminated_code: int) -> None:
        self.exit_code: int | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._has_loop_answered = False
        # The command runs, and has not waited for anything yet.
        self._is_at_start = False
        self._arrived_s = 0.0
        self._codes = {signal.SIGINT: EXIT_INTERRUPTED, signal.SIGTERM: terminated_code}
        # Windows has no SIGHUP. A closed terminal ends a command as SIGTERM does, unless it runs under nohup.
        if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
            self._codes[signal.SIGHUP] = terminated_code
        self._handlers_before = {number: signal.getsignal(number) for number in self._codes}

    def watch_start(self) -> None:
        """Note a Ctrl-C before the command runs; with asyncio's own handler, a clean-up could suppress it."""
        # Windows has no SIGALRM; there, asyncio handles Ctrl-C.
        handler = self._handle_signal if hasattr(signal, "SIGALRM") else signal.default_int_handler
        # A thread must not set handlers.
        with contextlib.suppress(ValueError):
            signal.signal(signal.SIGINT, handler)
        if was_interrupted():
            self.exit_code = EXIT_INTERRUPTED

    async def run(self, main: Coroutine[Any, Any, T]) -> T:
        """Return the command's result. Raises CancelledError after a signal."""
        task, loop = asyncio.current_task(), asyncio.get_running_loop()
        self._loop = loop
        assert task is not None

        def cancel() -> None:
            self._has_loop_answered = True
            # A second cancellation would end the clean-up after the first.
            if not task.cancelling():
                task.cancel()

        with contextlib.suppress(NotImplementedError):
            for number in self._codes:
                loop.add_signal_handler(number, cancel)
                # Python calls this handler during a computation, before the loop calls its own.
                signal.signal(number, self._handle_signal)
        if self.exit_code is not None:
            main.close()
            raise asyncio.CancelledError
        # The loop calls this when the command waits for the first time.
        loop.call_soon(self._note_wait)
        # Commands on uvloop read their files before the loop starts, and uvloop may handle KeyboardInterrupt.
        self._is_at_start = isinstance(loop, asyncio.BaseEventLoop)
        try:
            return await main
        finally:
            self._is_at_start = False
            self._keep_handlers(loop)

    def _keep_handlers(self, loop: asyncio.AbstractEventLoop) -> None:
        """Replace the loop's handlers while signals are blocked: a closing loop sets the default ones."""
        if not hasattr(signal, "pthread_sigmask"):
            return
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, self._codes)
        try:
            for number in self._codes:
                if loop.remove_signal_handler(number):
                    signal.signal(number, self._handle_signal)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)

    def _handle_signal(self, number: int, _frame: object) -> None:
        code = self._codes[signal.Signals(number)]
        now_s = time.monotonic()
        if self.exit_code is not None:
            if now_s - self._arrived_s > SAME_SIGNAL_S:
                os._exit(code)
            return
        self.exit_code, self._arrived_s = code, now_s
        signal.signal(signal.SIGALRM, self._handle_alarm)
        signal.setitimer(signal.ITIMER_REAL, BUSY_S, BUSY_S)
        if self._is_at_start:
            # The command reads its files, perhaps from a pipe that is silent, and has nothing to leave.
            self._handle_alarm(signal.SIGALRM, None)

    def _handle_alarm(self, _number: int, _frame: object) -> None:
        loop = self._loop
        if loop is None or loop.is_closed():
            return
        if self._has_loop_answered:
            self._has_loop_answered = False
            loop.call_soon_threadsafe(self._answer)
            return
        self._has_loop_answered = True
        # Tasks that are canceled here have nothing to report.
        loop.set_exception_handler(lambda loop, context: None)
        raise KeyboardInterrupt

    def _answer(self) -> None:
        self._has_loop_answered = True

    def _note_wait(self) -> None:
        self._is_at_start = False

    def stop(self) -> None:
        """Stop checking whether the loop is busy, and handle signals as before."""
        if self.exit_code is not None and hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in self._handlers_before.items():
            # A second SIGTERM or SIGHUP must not change the exit code of a command that the first one ended.
            # When Python exits, it restores the default handlers, but not those of ignored signals.
            if handler is signal.SIG_DFL and self.exit_code is not None:
                atexit.register(signal.signal, number, signal.SIG_IGN)
                continue
            # ValueError in a thread, TypeError for a handler that Python did not set.
            with contextlib.suppress(ValueError, TypeError):
                signal.signal(number, handler)


def _loop_factory(uvloop: bool | None) -> Callable[[], asyncio.AbstractEventLoop] | None:
    if uvloop is False:
        return None
    try:
        import uvloop as implementation
    except ImportError:
        if uvloop is None:
            return None
        raise ConfigError(
            f"uvloop is not installed; run: {install_command('uvloop')}; or omit --uvloop"
        ) from None
    factory: Callable[[], asyncio.AbstractEventLoop] = implementation.new_event_loop
    return factory


async def notifying_systemd(main: Coroutine[Any, Any, T]) -> T:
    """Return the result of `main`; while its loop runs, send READY=1 and WATCHDOG=1 to NOTIFY_SOCKET.

    The watchdog's period is half of WATCHDOG_USEC. A blocked loop sends nothing.
    """
    # The socket is not for programs that this one starts.
    address = os.environ.pop("NOTIFY_SOCKET", "")
    if not address:
        return await main
    if address.startswith("@"):
        address = f"\0{address[1:]}"
    limit_us = os.environ.pop("WATCHDOG_USEC", "")
    period_s = int(limit_us) / 2e6 if limit_us.isdecimal() else None
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notifications:
        notifications.setblocking(False)

        def send(state: bytes) -> None:
            # A manager that has ended or is slow must not end its service.
            with contextlib.suppress(OSError):
                notifications.sendto(state, address)

        async def keep_alive() -> None:
            send(b"READY=1")
            while period_s is not None:
                send(b"WATCHDOG=1")
                await asyncio.sleep(period_s)

        alive = asyncio.create_task(keep_alive())
        try:
            return await main
        finally:
            alive.cancel()
            send(b"STOPPING=1")
