"""Keeps one link open: waits for a port that is not there, and opens it again each time it was lost."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from rostether.bridge.reporter import Reporter
from rostether.errors import TransportError
from rostether.graph.ports import Level
from rostether.transports.address import Address, SerialAddress
from rostether.transports.backoff import Backoff
from rostether.transports.transport import Transport

# A board that is plugged in answers within a second of being seen; a look costs microseconds.
PRESENCE_POLL_S = 0.2
# A link that cannot be opened is tried at least this often: people correct a cable and look at the screen.
MAX_RETRY_S = 1.0
# udev gives a new port its group a moment after it appears: only a refusal that lasts is worth a line.
SETTLE_S = 1.0


class OpenLink(Protocol):
    """Opens the link."""

    def __call__(self, address: Address) -> Awaitable[Transport]:
        """Open. Raises TransportError."""


class ServeLink(Protocol):
    """Uses an open link until it ends."""

    def __call__(
        self, address: Address, transport: Transport, serial_number: str | None
    ) -> Awaitable[TransportError | None]:
        """Serve; returns why the link ended, None if it was our own wish."""


def _exists(path: str) -> bool:
    return Path(path).exists()


class LinkKeeper:
    """Keeps the link of one address."""

    def __init__(self, address: Address, open_link: OpenLink, serve: ServeLink, reporter: Reporter) -> None:
        self._address = address
        self._open_link = open_link
        self._serve = serve
        self._reporter = reporter
        # Where the same board is found when it comes back under another number.
        self._by_id: str | None = None

    async def run(self) -> None:
        """Serve the link until cancelled."""
        while True:
            address, transport = await self._open()
            serial_number = self._identify(address)
            error = await self._serve(address, transport, serial_number)
            if error is not None:
                self._reporter.line(Level.WARN, str(error))
            # An own close, after a fault of the session, must not become a busy loop.
            await asyncio.sleep(PRESENCE_POLL_S)

    async def _open(self) -> tuple[Address, Transport]:
        loop = asyncio.get_running_loop()
        backoff = Backoff(limit_s=MAX_RETRY_S)
        began_s = loop.time()
        told = ""
        while True:
            address = await self._wait_present()
            try:
                transport = await self._open_link(address)
            except TransportError as error:
                lasting = loop.time() - began_s >= SETTLE_S or not isinstance(address, SerialAddress)
                if lasting and str(error) != told:
                    told = str(error)
                    self._reporter.line(Level.ERROR, f"{told} (trying again)")
                await asyncio.sleep(backoff.next_delay_s())
                continue
            baud = f" at {address.baud} baud" if isinstance(address, SerialAddress) else ""
            self._reporter.line(Level.INFO, f"Connecting to {address}{baud}")
            return address, transport

    async def _wait_present(self) -> Address:
        address = self._address
        if not isinstance(address, SerialAddress) or "/" not in address.path:
            return address
        told = False
        while True:
            for path in (address.path, self._by_id):
                if path is not None and _exists(path):
                    return address if path == address.path else replace(address, path=path)
            if not told:
                told = True
                self._reporter.line(
                    Level.WARN, f"{address.path} is not there; waiting for it to be plugged in"
                )
            await asyncio.sleep(PRESENCE_POLL_S)

    def _identify(self, address: Address) -> str | None:
        """Return the USB serial number behind a serial port, and remember where the board is found by it."""
        if not isinstance(address, SerialAddress):
            return None
        from rostether.transports.serial import list_ports  # imports serialx, which is open by now anyway

        real_path = str(Path(address.path).resolve())
        for port in list_ports():
            if port.path == real_path:
                self._by_id = port.by_id
                return port.serial_number
        return None
