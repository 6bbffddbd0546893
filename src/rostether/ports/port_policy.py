"""Decides which ports discovery may open: known boards, and ports that the user allows."""

from __future__ import annotations

from enum import Enum, auto

from rostether.ports.board_identity import BoardIdentity
from rostether.ports.port_pattern import fits_entry
from rostether.ports.settings import DeviceSettings, DiscoverySettings
from rostether.ports.usb_boards import Kind, kind_of
from rostether.transports.serial_port import SerialPort


class PortUse(Enum):
    """How a port may be used."""

    # The user's file describes it: connect without detecting its speed.
    SERVE = auto()
    # The user named it as a board: probe until it answers.
    EXPECT = auto()
    # A board, which may run any sketch: probe for rosserial.
    ASK = auto()
    # Probably a board: listen first, and probe only if no other device sends.
    LISTEN = auto()
    # On USB, but of an unknown kind: not opened; the report says how to allow it.
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


def choose(port: SerialPort, settings: DeviceSettings, discovery: DiscoverySettings) -> PortUse:
    """Decide about a port; `settings` are those of its board."""
    identity = identify(port)
    if settings.match is not None:
        # Checked first, so that `ignore = ["all"]` does not exclude boards in the file.
        return PortUse.SERVE if settings.baud is not None else PortUse.EXPECT
    if any(fits_entry(identity, entry) for entry in discovery.ignore):
        return PortUse.LEAVE
    if any(fits_entry(identity, entry) for entry in discovery.probe):
        return PortUse.EXPECT
    match kind_of(port.usb_vendor_id, port.usb_product_id):
        case Kind.BOARD:
            return PortUse.ASK
        case Kind.LIKELY_BOARD:
            return PortUse.LISTEN
        case _:
            return PortUse.OFFER if port.usb_vendor_id is not None else PortUse.LEAVE
