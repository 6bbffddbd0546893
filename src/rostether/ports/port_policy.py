"""Decides which ports discovery may open: known boards, and ports that the user allows."""

from __future__ import annotations

import os
from collections.abc import Callable
from enum import Enum, auto
from pathlib import Path

from msgspec.structs import replace

from rostether.ports.board_identity import BoardIdentity
from rostether.ports.port_pattern import fits_entry
from rostether.ports.port_watch import SETTLING_S, folder_mark
from rostether.ports.settings import DeviceSettings, DiscoverySettings
from rostether.ports.usb_boards import UsbKind, usb_kind
from rostether.transports.serial_port import ListPorts, SerialPort


class PortUse(Enum):
    """How a port may be used."""

    # The user's file describes it: connect without detecting its baud rate.
    SERVE = auto()
    # The user named it as a board: probe until it answers.
    EXPECT = auto()
    # A board, which may run any sketch: probe for rosserial.
    ASK = auto()
    # Probably a board: listen first, and probe only if no other device sends.
    LISTEN = auto()
    # On USB, but of an unknown kind: not opened; a report describes how to allow it.
    OFFER = auto()
    # Not opened and not reported: not a USB device, or ignored by the user's settings.
    LEAVE = auto()


def identify(port: SerialPort) -> BoardIdentity:
    """Return the identity of the device on a port."""
    return BoardIdentity(
        usb_id=port.usb_id,
        serial_number=port.serial_number,
        usb_location=port.usb_location,
        usb_interface=port.usb_interface,
        port=port.path,
    )


def port_use(port: SerialPort, settings: DeviceSettings, discovery: DiscoverySettings) -> PortUse:
    """Return how a port may be used; `settings` are those of its board."""
    identity = identify(port)
    if settings.match is not None:
        # Checked first, so that `ignore = ["all"]` does not exclude boards in the file.
        return PortUse.SERVE if settings.baud is not None else PortUse.EXPECT
    if any(fits_entry(identity, entry) for entry in discovery.ignore):
        return PortUse.LEAVE
    if any(fits_entry(identity, entry) for entry in discovery.probe):
        return PortUse.EXPECT
    match usb_kind(port.usb_vendor_id, port.usb_product_id):
        case UsbKind.BOARD:
            return PortUse.ASK
        case UsbKind.LIKELY_BOARD:
            return PortUse.LISTEN
        case _:
            return PortUse.OFFER if port.usb_vendor_id is not None else PortUse.LEAVE


class PortFinder:
    """Finds the board that was last seen at `path`; at first, any board at `path`."""

    def __init__(self, path: str, list_ports: ListPorts, clock: Callable[[], float]) -> None:
        self._path = path
        self._list_ports = list_ports
        self._clock = clock
        self._identity: BoardIdentity | None = None
        self._mark: int | None = None
        self._lists_until_s = float("-inf")
        self._elsewhere: str | None = None

    def identify(self, path: str) -> BoardIdentity:
        """Return the identity of the board at a path, and search for this board from now on."""
        real_path = os.path.realpath(path)
        for port in self._list_ports():
            if port.path == real_path:
                found = identify(port)
                if found.own_serial_number is not None or found.usb_location is not None:
                    self._identity = found
                return replace(found, port=path)
        return BoardIdentity(port=path)

    def find(self) -> str | None:
        """Return the board's current path, None while it is unplugged; a call takes about 10 µs."""
        if self._identity is not None and (path := self._find_elsewhere(self._identity)) is not None:
            return path
        return self._path if Path(self._path).exists() else None

    def _find_elsewhere(self, identity: BoardIdentity) -> str | None:
        """Return the path of the known board if it is not at the usual path."""
        now_s, mark = self._clock(), folder_mark(str(Path(identity.port or self._path).parent))
        if mark != self._mark:
            self._mark, self._lists_until_s = mark, now_s + SETTLING_S
        if now_s < self._lists_until_s:
            here = os.path.realpath(self._path)
            self._elsewhere = None
            for port in self._list_ports():
                if port.path != here and identify(port).key == identity.key:
                    self._elsewhere = port.path
        return self._elsewhere if self._elsewhere and Path(self._elsewhere).exists() else None
