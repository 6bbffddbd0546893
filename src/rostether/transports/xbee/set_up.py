"""Sets up an XBee radio for a network of boards: finds its baud rate, sets its registers."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable

from msgspec import Struct

from rostether.errors import ConfigError, TransportError, TransportTimeoutError
from rostether.transports.transport import Transport
from rostether.transports.xbee.command_line import CommandLine
from rostether.transports.xbee.radio_address import is_long

# The values of BD.
BAUD_CODES = {1200: 0, 2400: 1, 4800: 2, 9600: 3, 19200: 4, 38400: 5, 57600: 6, 115200: 7}
# The rate of a new radio, then of one that was set up before, then all others that a radio may have.
SEARCHED_BAUDS = (9600, 57600, 115200, 38400, 19200, 4800, 2400, 1200)
# A port that was just closed may still be busy for a moment.
_REOPEN_S = 0.05

_NO_SHORT_ADDRESS = 0xFFFF
_SERIES_3_HARDWARE = 0x40


OpenAt = Callable[[int], Awaitable[Transport]]


class RadioSettings(Struct, frozen=True):
    """The settings for a radio.

    `address` is a 16-bit address; with None, the radio uses its own 64-bit address.
    `coordinator_address` is where a board sends: 0, or the 64-bit address of the radio at the host.
    """

    address: int | None
    is_coordinator: bool = False
    coordinator_address: int = 0
    pan_id: int = 0x1331
    channel: int = 0x0D
    baud: int = 57600


class RadioFound(Struct, frozen=True):
    """A radio that answered: `serial_number` is its 64-bit address."""

    baud: int
    hardware: int
    firmware: int
    serial_number: int
    is_mesh: bool

    @property
    def kind(self) -> str:
        """The series and its protocol, as text for users."""
        series = "series 3" if self.hardware >> 8 >= _SERIES_3_HARDWARE else "series 1 or 2"
        return f"{series}, {'DigiMesh' if self.is_mesh else '802.15.4'}"


async def set_up_radio(
    open_at: OpenAt, settings: RadioSettings, report: Callable[[str], None]
) -> tuple[RadioFound, list[str]]:
    """Set up the radio on a port that `open_at` opens at a baud rate; return it and the commands it accepted.

    `report` gets a line for each step that takes time. Raises ConfigError for settings that the radio cannot
    have, TransportError if no radio answers or one refuses a command.
    """
    for baud in SEARCHED_BAUDS:
        report(f"Looking for an XBee at {baud} baud")
        async with CommandLine(await open_at(baud)) as line:
            await line.leave_api_mode()
            if await line.enter():
                found = await _identify(line, baud)
                return found, await _program(line, radio_commands(settings, found))
        await asyncio.sleep(_REOPEN_S)
    raise TransportTimeoutError(
        f"no XBee answers at {', '.join(map(str, SEARCHED_BAUDS))} baud; check the port and the adapter, or "
        "restore the radio's factory settings with Digi's XCTU"
    )


def radio_commands(settings: RadioSettings, found: RadioFound) -> list[str]:
    """Return the AT commands that set up a radio. Raises ConfigError if its protocol lacks a setting."""
    needs_long = settings.address is None and not settings.is_coordinator
    if found.is_mesh and not settings.is_coordinator and not is_long(settings.coordinator_address):
        raise ConfigError(
            "a DigiMesh radio has no 16-bit address; give --to and the 64-bit address of the radio at the "
            "host, which its own set-up prints"
        )
    if needs_long and not is_long(settings.coordinator_address):
        raise ConfigError("give the radio's ADDRESS, or --to and the 64-bit address of the radio at the host")
    high, low = divmod(settings.coordinator_address, 2**32)
    commands = ["RE"]
    if settings.is_coordinator:
        commands.append("AP2")
    if not found.is_mesh:
        if settings.is_coordinator:
            commands.append("CE1")
        commands.append(f"MY{_NO_SHORT_ADDRESS if settings.address is None else settings.address:X}")
        # Adds a random delay also before the first attempt: boards that answer one request would all collide.
        commands.append("RN1")
    commands += [
        f"BD{BAUD_CODES[settings.baud]}",
        f"ID{settings.pan_id:X}",
        f"CH{settings.channel:X}",
        f"DH{high:X}",
        f"DL{low:X}",
        # A packet is sent after 5 characters of silence: a board's message is not cut into many.
        "RO5",
        "WR",
    ]
    return commands


async def _identify(line: CommandLine, baud: int) -> RadioFound:
    hardware, firmware = await line.read("HV"), await line.read("VR")
    high, low = await line.read("SH"), await line.read("SL")
    # Only a mesh has hops.
    hops = await line.read("NH")
    return RadioFound(baud, hardware or 0, firmware or 0, (high or 0) << 32 | (low or 0), hops is not None)


async def _program(line: CommandLine, commands: list[str]) -> list[str]:
    for command in commands:
        if not await line.execute(command):
            raise TransportError(
                f"the XBee refuses AT{command}; check the value, or update its firmware with Digi's XCTU"
            )
    # The flash already has all settings; some radios answer this at their new baud rate.
    with contextlib.suppress(TransportTimeoutError):
        await line.execute("CN")
    return commands
