"""Running a command's coroutine to a clean end, however it is asked to stop.

Ctrl-C and SIGTERM cancel the command, which then leaves the graph; a second Ctrl-C does not wait for that.
Like rospy's nodes, and unlike most programs, a command takes SIGINT also where a shell has started it in the
background and told it to ignore that: `command & ... kill -INT $!` is how scripts end ROS programs.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

import click

from rostether.cli.shell.failures import EXIT_DONE, EXIT_INTERRUPTED
from rostether.cli.shell.library_logs import show_library_logs
from rostether.errors import ConfigError
from rostether.extras import install_command
from rostether.transports.descriptors import allow_many_descriptors

T = TypeVar("T")

EXIT_TERMINATED = 143
"""What a shell reports for a program that SIGTERM ended."""


def run(main: Coroutine[Any, Any, T], *, is_service: bool = False, uvloop: bool | None = False) -> T:
    """Run a command. Ctrl-C exits with 130, SIGTERM with 143, or with 0 for a service that was told to end.

    `uvloop`: True demands it, None takes it when it is installed.
    """
    show_library_logs()
    if is_service:
        allow_many_descriptors()
    try:
        with asyncio.Runner(loop_factory=_loop_factory(uvloop)) as runner:
            return runner.run(_until_terminated(main, EXIT_DONE if is_service else EXIT_TERMINATED))
    except KeyboardInterrupt:
        raise click.exceptions.Exit(EXIT_INTERRUPTED) from None


async def _until_terminated(main: Coroutine[Any, Any, T], terminated_code: int) -> T:
    task = asyncio.current_task()
    assert task is not None
    exit_code: int | None = None

    def end(code: int) -> None:
        nonlocal exit_code
        if exit_code is not None:
            os._exit(code)
        exit_code = code
        task.cancel()

    loop = asyncio.get_running_loop()
    with contextlib.suppress(NotImplementedError):
        loop.add_signal_handler(signal.SIGINT, end, EXIT_INTERRUPTED)
        loop.add_signal_handler(signal.SIGTERM, end, terminated_code)
        # A closed terminal ends a command as SIGTERM does, unless nohup asked otherwise.
        if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
            loop.add_signal_handler(signal.SIGHUP, end, terminated_code)
    try:
        return await main
    except asyncio.CancelledError:
        if exit_code is None:
            raise
        raise click.exceptions.Exit(exit_code) from None


def _loop_factory(uvloop: bool | None) -> Callable[[], asyncio.AbstractEventLoop] | None:
    if uvloop is False:
        return None
    try:
        import uvloop as implementation
    except ImportError:
        if uvloop is None:
            return None
        raise ConfigError(
            f"uvloop is not installed; type: {install_command('uvloop')}; or leave --uvloop out"
        ) from None
    factory: Callable[[], asyncio.AbstractEventLoop] = implementation.new_event_loop
    return factory
