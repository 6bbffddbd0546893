"""Running a command's coroutine to a clean end, however it is asked to stop.

Ctrl-C and SIGTERM cancel the command, which then leaves the graph; a second Ctrl-C does not wait for that.
"""

from __future__ import annotations

import asyncio
import contextlib
import signal
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

import click

from rostether.cli.failures import EXIT_DONE, EXIT_INTERRUPTED
from rostether.errors import ConfigError

T = TypeVar("T")

EXIT_TERMINATED = 143
"""What a shell reports for a program that SIGTERM ended."""


def run(main: Coroutine[Any, Any, T], *, is_service: bool = False, uvloop: bool | None = False) -> T:
    """Run a command. Ctrl-C exits with 130, SIGTERM with 143, or with 0 for a service that was told to end.

    `uvloop`: True demands it, None takes it when it is installed.
    """
    try:
        with asyncio.Runner(loop_factory=_loop_factory(uvloop)) as runner:
            return runner.run(_until_terminated(main, EXIT_DONE if is_service else EXIT_TERMINATED))
    except KeyboardInterrupt:
        raise click.exceptions.Exit(EXIT_INTERRUPTED) from None


async def _until_terminated(main: Coroutine[Any, Any, T], exit_code: int) -> T:
    task = asyncio.current_task()
    assert task is not None
    is_terminated = False

    def terminate() -> None:
        nonlocal is_terminated
        is_terminated = True
        task.cancel()

    loop = asyncio.get_running_loop()
    # A closed terminal ends a command as SIGTERM does, unless nohup asked otherwise.
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    for number in (getattr(signal, name) for name in names):
        if signal.getsignal(number) is not signal.SIG_IGN:
            with contextlib.suppress(NotImplementedError):
                loop.add_signal_handler(number, terminate)
    try:
        return await main
    except asyncio.CancelledError:
        if not is_terminated:
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
            "uvloop is not installed: pip install 'rostether[uvloop]', or leave --uvloop out"
        ) from None
    factory: Callable[[], asyncio.AbstractEventLoop] = implementation.new_event_loop
    return factory
