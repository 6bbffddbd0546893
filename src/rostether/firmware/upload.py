"""Flashes a board through its bootloader, with avrdude or arduino-cli.

Boards with native USB (Leonardo, Micro) enter the bootloader when their port is opened at 1200 baud and
closed. The port then disappears for a moment, and may come back under another name.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rostether.errors import FirmwareError, RostetherError
from rostether.firmware.boards import Board
from rostether.firmware.built_firmware import BuiltFirmware
from rostether.firmware.toolchain import find_arduino_cli
from rostether.mechanisms.program import run_program
from rostether.transports.address import SerialAddress
from rostether.transports.opening import list_serial_ports
from rostether.transports.serial_errors import explain_open_error, explain_permission, find_holder
from rostether.transports.serial_port import ListPorts

Show = Callable[[Sequence[str]], None]

TOUCH_BAUD = 1200
# A bootloader starts in two seconds, on a slow hub in five.
TOUCH_LIMIT_S = 10.0

# If the port does not disappear in this time, the board was already in its bootloader.
_STAYED_S = 5.0
_POLL_S = 0.1
# udev sets the group of a new port a moment after the port appears.
_SETTLE_S = 0.25
# The errors of avrdude when no bootloader answers.
_SILENT = ("not in sync", "not responding", "programmer is not", "timeout", "unable to open programmer")


def choose_port(board: Board, list_ports: ListPorts = list_serial_ports) -> str:
    """Return the port of the only board on USB, or of the only board of the wanted kind.

    Raises FirmwareError with a list of the ports if there is none or more than one. Ports that are not on
    USB, such as /dev/ttyS0, do not count: they exist without a board.
    """
    ports = list_ports()
    usb = [each for each in ports if each.usb_vendor_id is not None]
    fitting = [each for each in usb if (each.usb_vendor_id, each.usb_product_id) in board.usb_ids]
    for candidates in (fitting, usb):
        if len(candidates) == 1:
            return candidates[0].path
    if not ports:
        raise FirmwareError("no serial port found; plug in the board, or give its port with --port")
    if not usb:
        others = ", ".join(each.path for each in ports)
        raise FirmwareError(f"no board found on USB; plug it in, or give its port with --port ({others})")
    names = ", ".join(f"{each.path} ({each.description})" for each in usb)
    raise FirmwareError(f"there are several serial ports: {names}; choose one with --port")


async def prepare_upload(board: Board, port: str | None, *, uses_arduino_cli: bool = False) -> str:
    """Check that a board can be flashed; return its port, which is `port` if given.

    Raises FirmwareError or TransportOpenError: no program, no port, port busy, no permission.
    """
    chosen = choose_port(board) if port is None else port
    if uses_arduino_cli or not board.is_avr:
        find_arduino_cli(f"flashing {board.title}")
    else:
        await _find_avrdude(chosen)
    return chosen


async def upload(
    built: BuiltFirmware,
    port: str,
    *,
    uses_arduino_cli: bool = False,
    show: Show | None = None,
    list_ports: ListPorts = list_serial_ports,
) -> str:
    """Flash a board; return the output of the flashing program.

    Raises FirmwareError or TransportOpenError: no program, no port, port busy, no permission, no answer.
    """
    if built.simulated_libraries:
        name = built.simulated_libraries[0]
        raise FirmwareError(
            f"{built.sketch.name} was built with the {name} library of simulated boards; install Arduino's "
            f"own {name} library, or give its folder with --library"
        )
    if uses_arduino_cli or not built.board.is_avr:
        command = _arduino_cli_command(built, port)
    else:
        program = await _find_avrdude(port, list_ports)
        if built.board.needs_touch:
            port = await touch(port, list_ports)
        command = avrdude_command(program, built.board, port, built.image)
    if show is not None:
        show(command)
    ended = await run_program(command)
    output = ended.output.decode("utf-8", "replace")
    if ended.code:
        raise await asyncio.to_thread(_explain, output, built.board, port, Path(command[0]).name)
    return output


async def _find_avrdude(port: str, list_ports: ListPorts = list_serial_ports) -> str:
    """Return the path of avrdude. Raises FirmwareError or TransportOpenError if it cannot use the port."""
    program = shutil.which("avrdude")
    if program is None:
        raise FirmwareError("no avrdude on PATH; run: sudo apt install avrdude")
    # Runs in a thread, because finding the program that uses the port reads /proc.
    await asyncio.to_thread(check_port, port, list_ports)
    return program


def avrdude_command(program: str, board: Board, port: str, image: Path) -> list[str]:
    """Return the command that flashes a HEX file through a board's bootloader."""
    return [
        *(program, "-q", "-p", board.mcu, "-c", board.upload_protocol),
        *("-P", port, "-b", str(board.upload_speed_baud)),
        # The bootloader erases the pages that it writes; a chip erase would remove the bootloader.
        *("-D", "-U", f"flash:w:{image}:i"),
    ]


def check_port(port: str, list_ports: ListPorts = list_serial_ports) -> None:
    """Raise TransportOpenError if a port cannot be opened, FirmwareError if another program uses it."""
    if sys.platform == "win32":
        return
    try:
        handle = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise explain_open_error(SerialAddress(path=port), error, list_ports) from None
    os.close(handle)
    holder = find_holder(port)
    if holder is not None:
        raise FirmwareError(f"{port} is in use by {holder}; close that program")


async def touch(port: str, list_ports: ListPorts = list_serial_ports, limit_s: float = TOUCH_LIMIT_S) -> str:
    """Make a board with native USB enter its bootloader; return the bootloader's port.

    Raises FirmwareError if no bootloader appears in time, OSError if the port cannot be opened.
    """
    loop = asyncio.get_running_loop()
    before = {each.path for each in list_ports()}
    await _open_at_touch_baud(port)
    started_s = loop.time()
    has_vanished = False
    while (waited_s := loop.time() - started_s) < limit_s:
        await asyncio.sleep(_POLL_S)
        now = {each.path for each in list_ports()}
        new = sorted(now - before)
        if new or (port in now and (has_vanished or waited_s > _STAYED_S)):
            await asyncio.sleep(_SETTLE_S)
            return new[0] if new else port
        has_vanished |= port not in now
        before &= now
    raise FirmwareError(f"no bootloader answered on {port}; press the board's reset button twice")


async def _open_at_touch_baud(port: str) -> None:
    if sys.platform == "win32":
        from rostether.transports.serial import open_serial

        transport = await open_serial(SerialAddress(path=port, baud=TOUCH_BAUD))
        transport.abort()
        return
    import fcntl
    import struct
    import termios

    handle = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        attributes = termios.tcgetattr(handle)
        attributes[4] = attributes[5] = termios.B1200
        termios.tcsetattr(handle, termios.TCSANOW, attributes)
        # A pseudo-terminal has no DTR line.
        with contextlib.suppress(OSError):
            fcntl.ioctl(handle, termios.TIOCMBIC, struct.pack("I", termios.TIOCM_DTR))
    finally:
        os.close(handle)


def _arduino_cli_command(built: BuiltFirmware, port: str) -> list[str]:
    program = find_arduino_cli(f"flashing {built.board.title}")
    folder = str(built.image.parent)
    return [program, "upload", "--fqbn", built.board.fqbn, "--port", port, "--input-dir", folder]


def _explain(output: str, board: Board, port: str, program: str) -> RostetherError:
    lowered = output.lower()
    if "permission denied" in lowered:
        return FirmwareError(explain_permission(port))
    if "resource busy" in lowered or "access is denied" in lowered:
        return FirmwareError(
            f"{port} is in use by {find_holder(port) or 'another program'}; close that program"
        )
    if any(each in lowered for each in _SILENT):
        old = (
            "; for a Nano with the old bootloader: --board nano:atmega328old" if "nano" in board.fqbn else ""
        )
        return FirmwareError(f"no {board.title} answers on {port}; check --board and the cable{old}")
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return FirmwareError(f"{program} failed: {lines[-1] if lines else 'it printed nothing'}")
