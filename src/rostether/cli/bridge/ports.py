"""`rostether ports`: the serial ports of this machine and their devices."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rostether.cli.shell.output import json_option, warn, write_result
from rostether.cli.shell.verbs import verb

if TYPE_CHECKING:
    from rostether.transports.serial_port import SerialPort


@verb("ports", "rostether ports\nrostether ports --json")
@json_option
def ports(as_json: bool) -> None:
    """List serial ports with their devices, and the names that `rostether serve` accepts.

    The second line of a USB port is a stable name: it does not change when you plug the board in elsewhere.
    """
    from rostether.ports.usb_boards import board_of
    from rostether.transports.port_facts import may_open
    from rostether.transports.serial import list_ports
    from rostether.transports.serial_errors import explain_permission

    found = list_ports()
    denied = [port.path for port in found if not may_open(port.path)]
    for port in found:
        board, is_accessible = board_of(port.usb_vendor_id, port.usb_product_id), port.path not in denied
        write_result(
            _record(port, board, is_accessible), _format(port, board, is_accessible), as_json=as_json
        )
    if not found:
        warn("no serial port found; connect a board with a USB cable that carries data, not only power")
    elif not as_json:
        for advice in dict.fromkeys(map(explain_permission, denied)):
            warn(advice)


def _format(port: SerialPort, board: str, is_accessible: bool) -> str:
    what = f"{board} ({port.description})" if board and board != port.description else port.description
    usb = f"  [{port.usb_id}]" if port.usb_id is not None else ""
    denied = "" if is_accessible else "  no permission"
    by_id = f"\n  {port.by_id}" if port.by_id else ""
    return f"{port.path}  {what}{usb}{denied}{by_id}"


def _record(port: SerialPort, board: str, is_accessible: bool) -> dict[str, object]:
    return {
        "path": port.path,
        "by_id": port.by_id,
        "description": port.description,
        "board": board or None,
        "manufacturer": port.manufacturer,
        "usb_id": port.usb_id,
        "serial_number": port.serial_number,
        "usb_location": port.usb_location,
        "is_accessible": is_accessible,
    }
