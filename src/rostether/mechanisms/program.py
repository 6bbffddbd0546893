"""Runs a program to its end; if the caller is canceled, the program and its children end too."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

# How long a program may take to end after SIGTERM, for example to remove its temporary files.
END_LIMIT_S = 5.0


class ProgramResult(NamedTuple):
    """The result of a program: its exit code, its output, and its error output if that is separate."""

    code: int
    output: bytes
    errors: bytes


async def run_program(
    command: Sequence[str],
    *,
    input_data: bytes | None = None,
    environ: Mapping[str, str] | None = None,
    merge: bool = True,
) -> ProgramResult:
    """Run a program with `input_data` as its input; `merge` puts its error output into its output.

    Raises OSError if it cannot be started.
    """
    starting = asyncio.ensure_future(
        asyncio.create_subprocess_exec(
            *command,
            stdin=asyncio.subprocess.DEVNULL if input_data is None else asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT if merge else asyncio.subprocess.PIPE,
            env=environ,
            # A separate process group, so that a compiler's children can be ended with it.
            start_new_session=True,
        )
    )
    try:
        process = await asyncio.shield(starting)
        output, errors = await process.communicate(input_data)
    except asyncio.CancelledError:
        await asyncio.shield(_end(starting))
        raise
    return ProgramResult(process.returncode or 0, output, errors or b"")


async def _end(starting: asyncio.Future[asyncio.subprocess.Process]) -> None:
    process = await starting
    signal_group(process, signal.SIGTERM)
    with suppress(TimeoutError):
        async with asyncio.timeout(END_LIMIT_S):
            await process.communicate()
            return
    signal_group(process, signal.SIGKILL)
    await process.communicate()


async def wait_or_kill(process: asyncio.subprocess.Process, limit_s: float) -> None:
    """Wait until a process has ended; kill it after `limit_s`, or if the caller is canceled."""
    try:
        async with asyncio.timeout(limit_s):
            await process.wait()
    except TimeoutError:
        pass
    finally:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()


def signal_group(process: asyncio.subprocess.Process, number: signal.Signals) -> None:
    """Signal a process that was started with `start_new_session`, and its children."""
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
