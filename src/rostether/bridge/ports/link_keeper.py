"""Keeps one link open: waits for a missing port, opens it again after each loss, and paces the attempts."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import TypeAlias

from msgspec.structs import replace

from rostether.bridge.identity import identify_peer
from rostether.bridge.reporter import Reporter
from rostether.errors import NodeEndedError, TransportError
from rostether.graph.ports import Level
from rostether.mechanisms.backoff import Backoff
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.device_book import DeviceBook
from rostether.ports.port_policy import PortFinder
from rostether.ports.settings import DeviceSettings
from rostether.transports.address import Address, SerialAddress
from rostether.transports.opening import list_serial_ports
from rostether.transports.serial_errors import is_pseudo_terminal
from rostether.transports.serial_port import ListPorts
from rostether.transports.transport import Transport

# Messages should flow half a second after a board is back, including the time to open its port; a check costs
# microseconds.
PRESENCE_POLL_S = 0.1
# For the same reason; an attempt that is refused costs 0.3 ms.
MAX_RETRY_S = 0.4

# Opens one link; raises TransportError.
OpenTransport: TypeAlias = Callable[[Address], Awaitable[Transport]]


# udev sets the group of a new port, and ModemManager releases it, a moment after it appears: only an error
# that lasts longer is reported.
SETTLE_S = 1.0

# Uses an open link until it ends; returns the error that ended it, None if the bridge ended it. Raises
# SessionError if it must not be served again.
ServeLink: TypeAlias = Callable[[Address, Transport, BoardIdentity], Awaitable[TransportError | None]]


class OpenAttempts:
    """Paces the attempts to open a link, and reports each new reason why they fail.

    `settle_s` is the time from the first attempt during which nothing is reported.
    """

    def __init__(
        self, backoff: Backoff, report: Callable[[str], object], *, settle_s: float = SETTLE_S
    ) -> None:
        self._backoff = backoff
        self._report = report
        self._report_at_s = asyncio.get_running_loop().time() + settle_s
        self._reported = ""

    async def wait_after(self, reason: str) -> None:
        """Report why an attempt failed, unless that was the last report, and wait for the next attempt."""
        if reason != self._reported and asyncio.get_running_loop().time() >= self._report_at_s:
            self._reported = reason
            self._report(reason)
        await asyncio.sleep(self._backoff.next_delay_s())


class LinkKeeper:
    """Keeps the link of one address open; `devices` may set a board's baud rate if the address does not.

    `list_ports` returns the system's list of serial ports.
    """

    def __init__(
        self,
        address: Address,
        open_link: OpenTransport,
        serve: ServeLink,
        reporter: Reporter,
        devices: DeviceBook,
        list_ports: ListPorts = list_serial_ports,
    ) -> None:
        self._address = address
        self._open_link = open_link
        self._serve = serve
        self._reporter = reporter
        self._devices = devices
        self._finder: PortFinder | None = None
        self._terminal_created_ns: int | None = None
        if isinstance(address, SerialAddress) and _comes_and_goes(address):
            self._finder = PortFinder(address.path, list_ports, asyncio.get_running_loop().time)

    async def run(self) -> None:
        """Serve the link until canceled."""
        while True:
            address, identity, transport = await self._open()
            try:
                error = await self._serve(address, transport, identity or identify_peer(transport.remote))
            except NodeEndedError:
                if self._finder is None:
                    raise
                # If the port were opened again immediately, a node that a user has ended would return.
                await self._wait_gone(self._finder)
                continue
            if error is not None:
                self._reporter.report(Level.WARN, str(error))
            # A link that we closed after an error of the session must not be opened again immediately.
            await asyncio.sleep(PRESENCE_POLL_S)

    async def _open(self) -> tuple[Address, BoardIdentity | None, Transport]:
        attempts = OpenAttempts(
            Backoff(limit_s=MAX_RETRY_S),
            lambda reason: self._reporter.report(Level.ERROR, f"{reason} (trying again)"),
            settle_s=SETTLE_S if isinstance(self._address, SerialAddress) else 0.0,
        )
        while True:
            path = await self._wait_until_present()
            address, identity = self._identify(path)
            try:
                at_path = isinstance(address, SerialAddress) and path is not None
                transport = await self._open_link(replace(address, path=path) if at_path else address)
            except TransportError as error:
                await attempts.wait_after(str(error))
                continue
            self._terminal_created_ns = None if path is None else _terminal_created_ns(path)
            baud = f" at {address.baud} baud" if isinstance(address, SerialAddress) else ""
            self._reporter.report(Level.INFO, f"Connecting to {path or address}{baud}")
            return address, identity, transport

    async def _wait_until_present(self) -> str | None:
        """Wait until the port exists; return its path, None for a link without a path."""
        if self._finder is None:
            return None
        reported: set[str] = set()
        while True:
            path = self._finder.find()
            if path is None:
                reason = f"{self._address} does not exist; waiting until it is plugged in"
            elif self._terminal_created_ns not in (None, _terminal_created_ns(path)):
                reason = (
                    f"{self._address} is now the terminal of another program and stays closed; "
                    "restart rostether with the new address of the board"
                )
            else:
                return path
            if reason not in reported:
                reported.add(reason)
                self._reporter.report(Level.WARN, reason)
            await asyncio.sleep(PRESENCE_POLL_S)

    async def _wait_gone(self, finder: PortFinder) -> None:
        while finder.find() is not None:  # noqa: ASYNC110 - systems report this in different ways
            await asyncio.sleep(PRESENCE_POLL_S)

    def _identify(self, path: str | None) -> tuple[Address, BoardIdentity | None]:
        """Return the address with the settings of the board at a serial port, and its identity."""
        address = self._address
        if self._finder is None or path is None or not isinstance(address, SerialAddress):
            return address, None
        identity = self._finder.identify(path)
        return with_settings(address, self._devices.settings_for(address.name, identity)), identity


def return_condition(address: Address) -> str:
    """Return when a board is served again after its node was shut down, in the words after "until"."""
    if address.listens:
        return "it reconnects"
    return "you unplug it and plug it in again" if _comes_and_goes(address) else "you restart rostether"


def identify_address(address: Address) -> BoardIdentity:
    """Return the known identity of a link's board before it answers: the USB identity of its port."""
    if isinstance(address, SerialAddress) and "/" in address.path:
        return PortFinder(address.path, list_serial_ports, lambda: 0.0).identify(address.path)
    return BoardIdentity()


def with_settings(address: SerialAddress, device: DeviceSettings) -> SerialAddress:
    """Return the address with a device's baud rate and reset, unless the address gives its own."""
    if device.baud is not None and "baud" not in address.given:
        address = replace(address, baud=device.baud)
    if device.reset is not None and "reset" not in address.given:
        address = replace(address, reset=device.reset)
    return address


def _comes_and_goes(address: Address) -> bool:
    """Return whether a link's port is a file that appears and disappears with its device; not on Windows."""
    return isinstance(address, SerialAddress) and "/" in address.path


def _terminal_created_ns(path: str) -> int | None:
    """Return when a pseudo-terminal was created; None for other ports and for symbolic links.

    The system gives the number of a closed pseudo-terminal to the next program that makes one.
    """
    if Path(path).is_symlink() or not is_pseudo_terminal(path):
        return None
    try:
        return os.stat(path).st_ctime_ns  # noqa: PTH116 - ten times a second
    except OSError:
        return None
