"""Controls an XBee radio on a serial port in its command mode: `+++`, then AT commands."""

from __future__ import annotations

import asyncio
from typing import Self

from rostether.errors import TransportClosedError, TransportError, TransportTimeoutError
from rostether.transports.transport import SmallWriter, Transport
from rostether.transports.xbee.frame import XbeeFrameDecoder
from rostether.transports.xbee.packets import AtAnswer, encode_at, parse_report

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
