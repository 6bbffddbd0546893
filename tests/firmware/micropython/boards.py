"""MicroPython as a board. Its heap has twice the bytes of a Pico's, because a Pico's words are half as
long.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
import tty
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from programs import Peer
from rostether.codegen.library_source import MICROPYTHON_FOLDER, client_library

PROGRAMS = Path(__file__).parent / "programs"
EXAMPLES = client_library() / MICROPYTHON_FOLDER / "examples"
INTERPRETER = (sys.executable, "-m", "micropython_unix", "-X", "heapsize=384k")


class UsbBoard:
    """A board whose program has the host's pseudo-terminal as standard input and output."""

    def __init__(
        self, program: Path, library: Path, arguments: Sequence[str], folders: Sequence[Path]
    ) -> None:
        self._command = (*INTERPRETER, str(program), *arguments)
        self._environment = _environment(library, *folders)
        self._leader, self._follower = os.openpty()
        tty.setraw(self._follower)
        self._process: asyncio.subprocess.Process | None = None
        self._reader: asyncio.Task[None] | None = None
        self.lines: list[str] = []
        self.address = os.ttyname(self._follower)

    async def start(self) -> None:
        """Start the program."""
        self._process = await asyncio.create_subprocess_exec(
            *self._command,
            stdin=self._leader,
            stdout=self._leader,
            stderr=asyncio.subprocess.PIPE,
            env=self._environment,
        )
        self._reader = asyncio.create_task(self._read(self._process))

    async def stop(self) -> None:
        """Kill the program, like a board that loses its power; the host's port stays open."""
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()
            self._process = None
        if self._reader is not None:
            await self._reader

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        assert process.stderr is not None
        async for line in process.stderr:
            self.lines.append(line.decode().rstrip("\n"))

    @property
    def has_ended(self) -> bool:
        """Return whether the program has ended by itself."""
        return self._process is not None and self._process.returncode is not None

    async def reset(self) -> None:
        """Start the program again."""
        await self.stop()
        await self.start()

    def close(self) -> None:
        """Close the pseudo-terminal."""
        os.close(self._leader)
        os.close(self._follower)


@contextlib.asynccontextmanager
async def usb_board(
    program: Path, library: Path, *arguments: str, folders: Sequence[Path] = ()
) -> AsyncIterator[UsbBoard]:
    """Run a program on a board at a USB port; its `lines` are those on standard error.

    `folders` have more modules.
    """
    board = UsbBoard(program, library, arguments, folders)
    try:
        await board.start()
        yield board
    finally:
        await board.stop()
        board.close()


@contextlib.asynccontextmanager
async def running(
    program: Path, library: Path, *arguments: str, on_cpython: bool = False
) -> AsyncIterator[Peer]:
    """Run a program that opens its line itself; yield the process with its output.

    `on_cpython` runs it on CPython, with the modules of CircuitPython that the library uses.
    """
    path = f"{library}:{PROGRAMS}:{PROGRAMS}/circuitpython"
    process = await asyncio.create_subprocess_exec(
        *([sys.executable] if on_cpython else INTERPRETER),
        str(program),
        *arguments,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        env=_environment(library) | ({"PYTHONPATH": path} if on_cpython else {}),
        start_new_session=True,
    )
    peer = Peer(process)
    peer.reader = asyncio.create_task(peer.read())
    try:
        yield peer
    finally:
        await peer.stop(signal.SIGKILL)


def run(program: Path, library: Path, text: str = "", heap: str = "384k") -> str:
    """Run a program to its end; return what it prints for a text on standard input."""
    command = [*INTERPRETER[:-1], f"heapsize={heap}", str(program)]
    completed = subprocess.run(
        command, env=_environment(library), input=text, capture_output=True, text=True, timeout=150
    )
    assert completed.returncode == 0, completed.stdout + completed.stderr
    return completed.stdout


def _environment(*folders: Path) -> dict[str, str]:
    return {**os.environ, "MICROPYPATH": ":".join([*map(str, folders), str(PROGRAMS), ".frozen"])}
