"""The states of one port that the search for boards may open: in use, probed, served, or ignored.

waits while another program uses it ──> opened ──> probed ──┬── a board: served until gone ──> again
   ^                                      │                 └── none: closed and left alone
   └────── reported, tried later <────────┘                        │
   └────── another program used it since (a new sketch?), or it was a board before <──┘
"""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Awaitable, Callable, Sequence

from msgspec import Struct

from rostether.bridge.ports.link_keeper import OpenAttempts, ServeLink
from rostether.bridge.ports.port_probe import TunableTransport, probe_port
from rostether.bridge.reporter import Reporter, shown_line
from rostether.errors import RostetherError, SessionError, TransportError
from rostether.graph.ports import Level
from rostether.mechanisms.backoff import Backoff
from rostether.mechanisms.text import counted
from rostether.ports.known_boards import KnownBoards
from rostether.ports.port_policy import PortUse, identify
from rostether.ports.port_watch import DEVICE_FOLDER
from rostether.ports.settings import DeviceSettings
from rostether.rosserial.baud_probe import BoardFound, NoBoard
from rostether.transports.address import DEFAULT_BAUD, SerialAddress
from rostether.transports.opening import list_serial_ports
from rostether.transports.port_holders import find_port_user
from rostether.transports.serial_port import ListPorts, SerialPort
from rostether.transports.transport import Transport

# Another program that tests a port uses it for a moment.
FIRST_RETRY_S = 0.25
# The longest pause between checks of a port in use: each check reads /proc.
MAX_RETRY_S = 5.0

# A board needs this time to start after it got power.
FIRST_REPROBE_S = 5.0
# A board that answered before, or that the user named, is probed again: it may have had no power.
MAX_REPROBE_S = 60.0

# How often an ignored port is checked (not opened) for signs that another program used it.
CHECK_PERIOD_S = 1.0

# A lost port disappears from the list of ports after a moment.
AFTER_LOSS_S = 0.1

# Linux asserts DTR at the first opening; while it stays asserted, later openings reset no board. On other
# systems it must be asserted at each opening.
RESETS_AT_CLOSE = sys.platform != "linux"


async def open_port(address: SerialAddress) -> TunableTransport:
    """Open a serial port. Raises TransportOpenError, ConfigError."""
    from rostether.transports.serial import open_serial  # imports serialx

    return await open_serial(address)


class MachinePorts(Struct, frozen=True):
    """The access to serial ports: `list_ports` returns the system's list, `folders` show when it changes.

    `find_port_user` names the other program that uses a port; it is called in a thread.
    """

    list_ports: ListPorts = list_serial_ports
    folders: Sequence[str] = (DEVICE_FOLDER,)
    open_port: Callable[[SerialAddress], Awaitable[TunableTransport]] = open_port
    find_port_user: Callable[[str], str | None] = find_port_user


THIS_MACHINE = MachinePorts()


class FoundPort:
    """Handles one port, in a task that ends when the port has disappeared, or when it is canceled.

    `is_dismissed`: another node shut down the board's node, so the port is not opened.
    """

    def __init__(
        self,
        port: SerialPort,
        choice: PortUse,
        settings: DeviceSettings,
        *,
        ports: MachinePorts,
        is_present: Callable[[SerialPort], bool],
        serve: ServeLink,
        known: KnownBoards,
        reporter: Reporter,
    ) -> None:
        self.port = port
        self.choice = choice
        self.identity = identify(port)
        self.is_serving = False
        self.is_dismissed = False
        self._settings = settings
        self._ports = ports
        self._is_present = is_present
        self._serve = serve
        self._known = known
        self._reporter = reporter
        self._title = f"{port.path} ({port.description})"
        self._reported = ""

    async def run(self) -> None:
        """Handle the port until it has disappeared."""
        reprobes = Backoff(first_s=FIRST_REPROBE_S, limit_s=MAX_REPROBE_S)
        while (transport := await self._open()) is not None:
            try:
                found = await self._probe(transport)
                if isinstance(found, BoardFound):
                    reprobes.reset()
                    await self._serve_board(transport, found.baud)
                    await asyncio.sleep(AFTER_LOSS_S)
                    continue
            except SessionError:
                self.is_dismissed = True
                return
            except TransportError:
                # The board was unplugged during the probe; the next list of ports shows this.
                await asyncio.sleep(AFTER_LOSS_S)
                continue
            finally:
                transport.close()
            await transport.wait_closed()
            self._report_no_board(found)
            was_board = self._known.baud_of(self.identity.key) is not None
            is_expected = was_board or self.choice is PortUse.EXPECT
            await self._leave_alone(reprobes.next_delay_s() if is_expected else None)

    async def _open(self) -> TunableTransport | None:
        """Open the port as soon as no other program uses it; None if it was removed."""
        attempts = OpenAttempts(
            Backoff(first_s=FIRST_RETRY_S, limit_s=MAX_RETRY_S),
            lambda reason: self._report(Level.WARN, reason),
        )
        while self._is_present(self.port):
            user = await asyncio.to_thread(self._ports.find_port_user, self.port.path)
            if user is None:
                try:
                    return await self._ports.open_port(self._address(self._first_baud()))
                except RostetherError as error:
                    refusal = f"{error} (trying again)"
            else:
                refusal = f"{self._title} is in use by {user}; waiting until it is free"
            await attempts.wait_after(refusal)
        return None

    async def _probe(self, transport: TunableTransport) -> BoardFound | NoBoard:
        if self.choice is PortUse.SERVE:
            return BoardFound(self._first_baud(), 0, b"")
        known_baud = self._known.baud_of(self.identity.key)
        found = await probe_port(
            transport,
            known_baud=known_baud,
            listens_first=self.choice is PortUse.LISTEN and known_baud is None,
        )
        if isinstance(found, BoardFound):
            self._reported = ""
            baud = f"{found.baud} baud, " if transport.has_baud else ""
            if self.identity.usb_id is not None:
                self._known.remember(self.identity.key, found.baud)
            self._reporter.report(
                Level.INFO, f"Found a board at {self._title}: {baud}protocol version {found.version}"
            )
        return found

    async def _serve_board(self, transport: Transport, baud: int) -> None:
        if self.choice is PortUse.SERVE:
            self._reporter.report(Level.INFO, f"Connecting to {self._title} at {baud} baud")
        self.is_serving = True
        try:
            error = await self._serve(self._address(baud), transport, self.identity)
        finally:
            self.is_serving = False
        if error is not None:
            self._reporter.report(Level.WARN, str(error))

    async def _leave_alone(self, reprobe_s: float | None) -> None:
        loop = asyncio.get_running_loop()
        left_s = loop.time()
        mark = _use_mark(self.port.path)
        while _use_mark(self.port.path) == mark:
            if reprobe_s is not None and loop.time() - left_s >= reprobe_s:
                return
            await asyncio.sleep(CHECK_PERIOD_S)

    def _first_baud(self) -> int:
        return self._settings.baud or self._known.baud_of(self.identity.key) or DEFAULT_BAUD

    def _address(self, baud: int) -> SerialAddress:
        resets = self._settings.reset if self._settings.reset is not None else RESETS_AT_CLOSE
        identity, name = self.identity, self._settings.name
        if name is None and identity.own_serial_number is None and identity.usb_location is not None:
            # The socket stays when the port's number changes.
            name = f"usb_{identity.usb_location}".translate(_NAME_OF_SOCKET)
        return SerialAddress(self.port.path, baud, resets, name=name)

    def _report_no_board(self, found: NoBoard) -> None:
        what = f"{self._title} does not answer as a rosserial board at any usual baud rate"
        if found.text_baud is not None:
            text = found.text.decode("ascii", "replace").strip()
            sent = f"text at {found.text_baud} baud ({text!r})"
            what = f"{self._title} sends {sent} and is not a rosserial board"
        elif found.foreign_bytes:
            size = counted(found.foreign_bytes, "byte")
            what = f"{self._title} sends data ({size}) that is not from a rosserial board"
        self._report(
            Level.WARN, f"{what}; ignoring it until it is plugged in again or another program has used it"
        )

    def _report(self, level: Level, text: str) -> None:
        """Report a line unless it was the last line of this port."""
        if text != self._reported:
            self._reported = text
            self._reporter.report(level, shown_line(text))


_NAME_OF_SOCKET = str.maketrans("-.:", "___")


def _use_mark(path: str) -> tuple[int, int] | None:
    """Return what changes when a program reads or writes a port: its file's times."""
    try:
        status = os.stat(path)  # noqa: PTH116 - once a second
    except OSError:
        return None
    return status.st_mtime_ns, status.st_atime_ns
