"""Sets up an XBee radio for a network of boards, in its command mode: baud rate and registers."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from typing import Self

from msgspec import Struct

from rostether.errors import ConfigError, TransportClosedError, TransportError, TransportTimeoutError
from rostether.transports.transport import SmallWriter, Transport
from rostether.transports.xbee.frame import XbeeFrameDecoder
from rostether.transports.xbee.packets import AtAnswer, encode_at, parse_report
from rostether.transports.xbee.radio_address import is_long

# The values of BD.
BAUD_CODES = {1200: 0, 2400: 1, 4800: 2, 9600: 3, 19200: 4, 38400: 5, 57600: 6, 115200: 7}
# The rate of a new radio, then of one that was set up before, then all others that a radio may have.
SEARCHED_BAUDS = (9600, 57600, 115200, 38400, 19200, 4800, 2400, 1200)
# A port that was just closed may still be busy for a moment.
_REOPEN_S = 0.05

_NO_SHORT_ADDRESS = 0xFFFF
_SERIES_3_HARDWARE = 0x40

# The silence around +++ is 1 s in a factory-fresh radio; the margin is for an adapter that delivers late.
GUARD_S = 1.1
# A radio answers +++ after its guard time.
_ENTER_LIMIT_S = 2.0
# WR writes the flash in less than a second.
_ANSWER_LIMIT_S = 2.0
_FRAME_ANSWER_LIMIT_S = 0.3
_MAX_REGISTER = 2**32 - 1
# Answers have at most 20 bytes; a board behind the radio may send without a pause.
_MAX_HELD_BYTES = 4096

_OK = b"OK"
_TRANSPARENT = b"\x00"
_FRAME_ID = 1

OpenAt = Callable[[int], Awaitable[Transport]]


class CommandLine(SmallWriter):
    """The commands of one radio: `+++`, then AT commands. It is made on an open transport, which it owns."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._received = bytearray()
        self._changed = asyncio.Event()
        self._error: TransportError | None = None
        self._has_ended = False
        transport.start(self)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close the port."""
        self._transport.close()
        await self._transport.wait_closed()

    def data_received(self, data: bytes) -> None:
        """Collect the bytes of an answer."""
        self._received += data
        del self._received[:-_MAX_HELD_BYTES]
        self._changed.set()

    def connection_lost(self, error: TransportError | None) -> None:
        """Record the end of the port."""
        self._has_ended, self._error = True, error
        self._changed.set()

    async def leave_api_mode(self) -> bool:
        """Set a radio in API mode to transparent; return False if none answers. Raises TransportError."""
        self._received.clear()
        self._transport.write(encode_at("AP", _TRANSPARENT, frame_id=_FRAME_ID))
        decoder = XbeeFrameDecoder()
        try:
            async with asyncio.timeout(_FRAME_ANSWER_LIMIT_S):
                while True:
                    await self._wait()
                    data, self._received = bytes(self._received), bytearray()
                    reports = map(parse_report, decoder.feed(data))
                    if any(isinstance(each, AtAnswer) and each.command == "AP" for each in reports):
                        return True
        except TimeoutError:
            return False

    async def enter(self) -> bool:
        """Enter command mode; return False if no radio answers at this baud rate. Raises TransportError."""
        await asyncio.sleep(GUARD_S)
        self._received.clear()
        self._transport.write(b"+++")
        try:
            async with asyncio.timeout(_ENTER_LIMIT_S):
                return await self._line() == _OK
        except TimeoutError:
            return False

    async def read(self, name: str) -> int | None:
        """Return a register, None if the radio does not have it. Raises TransportError."""
        answer = await self._ask(name)
        try:
            value = int(answer, 16)
        except ValueError:
            return None
        return value if 0 <= value <= _MAX_REGISTER else None

    async def execute(self, command: str) -> bool:
        """Run a command such as `WR`; return False if the radio refuses it. Raises TransportError."""
        return await self._ask(command) == _OK

    async def _ask(self, command: str) -> bytes:
        self._received.clear()
        self._transport.write(f"AT{command}\r".encode("ascii"))
        try:
            async with asyncio.timeout(_ANSWER_LIMIT_S):
                return await self._line()
        except TimeoutError:
            raise TransportTimeoutError(
                f"the XBee at {self._transport.peer} does not answer AT{command}; unplug it, plug it in and "
                "run this again"
            ) from None

    async def _line(self) -> bytes:
        while b"\r" not in self._received:
            await self._wait()
        line, _, rest = bytes(self._received).partition(b"\r")
        self._received = bytearray(rest)
        return line.strip()

    async def _wait(self) -> None:
        self._changed.clear()
        if not self._has_ended:
            await self._changed.wait()
        if self._has_ended:
            raise self._error or TransportClosedError(f"{self._transport.peer} is closed")


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
