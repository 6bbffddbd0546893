"""A simulated Cortex-M board: qemu-system-arm running an ELF, its UART on a pseudo-terminal.

async with await QemuBoard.start(elf) as board:
    ...                              # `board.address` is what `serve` opens
    await board.reset()
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import shutil
import struct
from pathlib import Path
from typing import Self

from rostether.errors import BoardError
from rostether.mechanisms.block_end import BlockClosable
from rostether.mechanisms.program import wait_or_kill
from rostether.transports.pty_link import PtyLink

PROGRAM = "qemu-system-arm"
# A TI Stellaris, the forerunner of the Tiva C with the same UART.
DEFAULT_MACHINE = "lm3s6965evb"
# The core of each machine, and the options that connect its UART.
MACHINES = {
    DEFAULT_MACHINE: ("Cortex-M3", ("-serial", "pty")),
    # An STM32F405. The library and ST's Nucleo boards use USART2, qemu's second serial port.
    "netduinoplus2": ("Cortex-M4", ("-serial", "null", "-serial", "pty")),
}
# qemu reports its terminal within 0.25 s on an idle machine.
START_LIMIT_S = 20.0
# qemu ends within milliseconds; after this time, it is killed.
END_LIMIT_S = 2.0
# qemu's last lines contain the reason for its end.
MAX_OUTPUT_BYTES = 4096

# The header of an ELF file: magic number, class (32 bits), byte order (little endian) and machine (ARM); then
# the offset, size and number of the program headers.
_HEADER = struct.Struct("<4sBB12xH8xI10xHH")
# A program header: the offset and size of a segment in the file.
_SEGMENT = struct.Struct("<4xI8xI12x")
_KIND = [b"\x7fELF", 1, 1, 40]

_TERMINAL = re.compile(rb"char device redirected to (\S+)")


class QemuBoard(BlockClosable):
    """One board.

    It ends with `close` and, if setpriv is installed, when this process is killed. `address` is the link
    address of its UART for `serve`. `exit_message` is qemu's error message after it has ended by itself.
    """

    def __init__(
        self, process: asyncio.subprocess.Process, terminal: str, link: PtyLink, output: bytes = b""
    ) -> None:
        self.address = terminal
        self._process = process
        self._link = link
        self.exit_message = ""
        # The output must be read, because qemu blocks if the pipe is full.
        self._reading = asyncio.get_running_loop().create_task(self._read(output))

    @classmethod
    async def start(
        cls, program: Path, *, machine: str = DEFAULT_MACHINE, link_path: Path | None = None
    ) -> Self:
        """Start an ELF file on a machine that qemu knows; `link_path` becomes a link to its terminal.

        Raises BoardError if qemu does not run it, TransportOpenError if `link_path` is in use.
        """
        if not is_arm_program(program):
            raise BoardError(
                f"{program} cannot run on the {machine}: it is not a complete ELF file for an ARM "
                "microcontroller; compile it with arm-none-eabi-g++"
            )
        link = PtyLink(link_path)
        qemu = shutil.which(PROGRAM)
        if qemu is None:
            raise BoardError(
                f"{PROGRAM} is not installed; on Debian and Ubuntu: sudo apt install qemu-system-arm"
            )
        # The kernel ends qemu if this process is killed; without setpriv only `close` ends it.
        setpriv = shutil.which("setpriv")
        guard = [setpriv, "--pdeathsig", "KILL"] if setpriv else []
        # For an unknown machine, qemu reports the error.
        _, serial = MACHINES.get(machine, MACHINES[DEFAULT_MACHINE])
        options = ["-machine", machine, "-display", "none", *serial, "-monitor", "stdio"]
        process = await asyncio.create_subprocess_exec(
            *guard,
            qemu,
            *options,
            "-kernel",
            str(program),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            # Ctrl-C ends this process, which then ends qemu.
            start_new_session=True,
        )
        try:
            async with asyncio.timeout(START_LIMIT_S):
                terminal, output = await _find_terminal(process)
            link.place(terminal)
            return cls(process, terminal, link, output)
        except BaseException as error:
            await _end(process)
            if isinstance(error, TimeoutError):
                raise BoardError(
                    f"{PROGRAM} did not start within {START_LIMIT_S:g} s; try again on an idle computer"
                ) from None
            raise

    @property
    def has_ended(self) -> bool:
        """Whether qemu has ended."""
        return self._reading.done()

    async def reset(self) -> None:
        """Press the reset button. Raises BoardError if the board has ended."""
        stdin = self._process.stdin
        assert stdin is not None
        if self.has_ended:
            raise BoardError("the simulated board has ended; start it again")
        with contextlib.suppress(ConnectionError):
            stdin.write(b"system_reset\n")
            await stdin.drain()

    async def wait_end(self) -> None:
        """Wait until qemu has ended."""
        await asyncio.shield(self._reading)
        await self._process.wait()

    async def close(self) -> None:
        """End qemu, and wait for its end. Idempotent."""
        self._link.remove()
        await _end(self._process)
        await self._reading

    async def _read(self, output: bytes) -> None:
        stdout = self._process.stdout
        assert stdout is not None
        while chunk := await stdout.read(4096):
            output = (output + chunk)[-MAX_OUTPUT_BYTES:]
        self.exit_message = _error_message(output)


def is_arm_program(path: Path) -> bool:
    """Return whether a file is a complete ELF file for ARM; qemu would run another file as a memory image.

    Returns False for a file that cannot be read.
    """
    try:
        with path.open("rb") as file:
            size_bytes = path.stat().st_size
            header = _HEADER.unpack(file.read(_HEADER.size))
            *kind, table, entry_bytes, entries = header
            file.seek(table)
            segments = file.read(entries * _SEGMENT.size)
            is_whole = all(at + size <= size_bytes for at, size in _SEGMENT.iter_unpack(segments))
    except (OSError, struct.error):
        return False
    is_complete = entries > 0 and len(segments) == entries * _SEGMENT.size
    return kind == _KIND and entry_bytes == _SEGMENT.size and is_complete and is_whole


async def _find_terminal(process: asyncio.subprocess.Process) -> tuple[str, bytes]:
    """Return the terminal of qemu, and its output so far, which may contain an error message."""
    stdout = process.stdout
    assert stdout is not None
    output = b""
    while chunk := await stdout.read(4096):
        output += chunk
        found = _TERMINAL.search(output)
        if found is not None:
            return found[1].decode(), output
    raise BoardError(f"{PROGRAM} does not run this program: {_error_message(output) or 'no reason given'}")


def _error_message(output: bytes) -> str:
    """Return the error message in the output of qemu and its monitor."""
    lines = (line.strip() for line in output.decode(errors="replace").splitlines())
    wrong = [line.removeprefix(f"{PROGRAM}: ") for line in lines if line.startswith(PROGRAM)]
    return wrong[-1] if wrong else ""


async def _end(process: asyncio.subprocess.Process) -> None:
    if process.stdin is not None:
        process.stdin.close()
    with contextlib.suppress(ProcessLookupError):
        process.terminate()
    await wait_or_kill(process, END_LIMIT_S)
