"""`rostether ports`: the serial ports of this machine and their devices."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rostether.cli.shell.output import json_option, warn, write_result
from rostether.cli.shell.verbs import verb

if TYPE_CHECKING:
    from rostether.transports.serial import SerialPort


@verb("ports", "rostether ports\nrostether ports --json")
@json_option
def ports(as_json: bool) -> None:
    """List serial ports with their devices, and the names that `rostether serve` accepts.

    The second line of a USB port is a stable name: it does not change when you plug the board in elsewhere.
    """
    from rostether.ports.usb_boards import board_of
    from rostether.transports.serial import list_ports
    from rostether.transports.serial_errors import explain_permission

    found = list_ports()
    for port in found:
        board = board_of(port.usb_vendor_id, port.usb_product_id)
        write_result(_record(port, board), _format(port, board), as_json=as_json)
    if not found:
        warn("no serial port found; connect a board with a USB cable that carries data, not only power")
    elif not as_json and any(not _is_accessible(port) for port in found):
        for advice in dict.fromkeys(
            explain_permission(port.path) for port in found if not _is_accessible(port)
        ):
            warn(advice)


def _format(port: SerialPort, board: str) -> str:
    what = f"{board} ({port.description})" if board and board != port.description else port.description
    usb = f"  [{_usb_id(port)}]" if port.usb_vendor_id is not None else ""
    denied = "" if _is_accessible(port) else "  no permission"
    by_id = f"\n  {port.by_id}" if port.by_id else ""
    return f"{port.path}  {what}{usb}{denied}{by_id}"


def _record(port: SerialPort, board: str) -> dict[str, object]:
    return {
        "path": port.path,
        "by_id": port.by_id,
        "description": port.description,
        "board": board or None,
        "manufacturer": port.manufacturer,
        "usb_id": _usb_id(port) if port.usb_vendor_id is not None else None,
        "serial_number": port.serial_number,
        "usb_location": port.usb_location,
        "is_accessible": _is_accessible(port),
    }


def _usb_id(port: SerialPort) -> str:
    return f"{port.usb_vendor_id or 0:04x}:{port.usb_product_id or 0:04x}"


def _is_accessible(port: SerialPort) -> bool:
    # Windows has no files for its ports.
    return os.name == "nt" or os.access(port.path, os.R_OK | os.W_OK)
