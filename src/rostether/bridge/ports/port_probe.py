"""Connects an open port to `rosserial.baud_probe`, which detects a board."""

from __future__ import annotations

import asyncio
from typing import Protocol

from rostether.errors import TransportClosedError, TransportError
from rostether.rosserial.baud_probe import USUAL_BAUDS, BaudProbe, BoardFound, NoBoard
from rostether.transports.transport import SmallWriter, Transport


class TunableTransport(Transport, Protocol):
    """An open serial port whose baud rate can be changed, and its receiver."""

    @property
    def has_baud(self) -> bool:
        """Whether the line has a baud rate: a pseudo-terminal has none."""

    def set_baud(self, baud: int) -> bool:
        """Change the baud rate; return False if the port does not support it."""

    def release(self, unread: bytes = b"") -> None:
        """Stop delivering; the receiver of the next `start` gets the `unread` bytes first."""


async def probe_port(
    transport: TunableTransport, *, known_baud: int | None = None, listens_first: bool = False
) -> BoardFound | NoBoard:
    """Detect whether a board is connected, and leave the port ready for the session that serves it.

    Without a board it takes up to about 35 s. Raises TransportError if the port is lost.
    """
    bauds = USUAL_BAUDS if transport.has_baud else USUAL_BAUDS[:1]
    if not transport.has_baud:
        known_baud = None
    probe = BaudProbe(bauds, known_baud=known_baud, listens_first=listens_first)
    return await _Probing(transport, probe).run()


class _Probing(SmallWriter):
    """The transport's receiver while the probe runs."""

    def __init__(self, transport: TunableTransport, probe: BaudProbe) -> None:
        self._transport = transport
        self._probe = probe
        self._loop = asyncio.get_running_loop()
        self._woken = asyncio.Event()
        self._baud: int | None = None
        self._lost: TransportError | None = None

    async def run(self) -> BoardFound | NoBoard:
        """Return the result of the probe. Raises TransportError if the port is lost."""
        self._probe.start(self._loop.time())
        self._apply()
        self._transport.start(self)
        while self._probe.result is None:
            if self._lost is not None:
                raise self._lost
            due_s = self._probe.get_timer()
            self._woken.clear()
            try:
                async with asyncio.timeout_at(due_s):
                    await self._woken.wait()
            except TimeoutError:
                self._probe.handle_timer(self._loop.time())
                self._apply()
        if self._lost is not None:
            raise self._lost
        found = self._probe.result
        if isinstance(found, BoardFound):
            self._set_baud(found.baud)
            self._transport.release(found.received)
        return found

    def data_received(self, data: bytes) -> None:
        """Handle a chunk."""
        if self._probe.result is None:
            self._probe.receive_data(data, self._loop.time())
            self._apply()
            if self._probe.result is not None:
                # Until the session starts, received bytes wait in the port.
                self._transport.pause_reading()
        self._woken.set()

    def connection_lost(self, error: TransportError | None) -> None:
        """End the probe: the port was removed."""
        self._lost = error or TransportClosedError(f"{self._transport.peer} was closed during the probe")
        self._woken.set()

    def _apply(self) -> None:
        self._set_baud(self._probe.baud)
        data = self._probe.data_to_send()
        if data:
            self._transport.write(data)

    def _set_baud(self, baud: int) -> None:
        if baud != self._baud:
            self._baud = baud
            self._transport.set_baud(baud)
