"""Serial ports as the system lists them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from typing import TypeAlias

from msgspec import Struct

# Bus, the sockets of the hubs on the way, configuration and interface: `1-1.2:1.0`.
_USB_INTERFACE = re.compile(r"[0-9]+-[0-9.]+:[0-9]+\.[0-9]+")


class SerialPort(Struct, frozen=True):
    """One serial port of this machine; the USB fields are None if the port is not on USB.

    `usb_location` is the socket that the device is plugged into, with the interface: it stays the
    same when the port gets a different number (Linux only).
    """

    path: str
    description: str
    by_id: str | None = None
    usb_vendor_id: int | None = None
    usb_product_id: int | None = None
    serial_number: str | None = None
    manufacturer: str | None = None
    usb_location: str | None = None
    usb_interface: int | None = None

    @property
    def usb_id(self) -> str | None:
        """Vendor and product in the usual form, `2341:0043`."""
        if self.usb_vendor_id is None:
            return None
        return f"{self.usb_vendor_id:04x}:{self.usb_product_id or 0:04x}"


# Lists the ports of this machine.
ListPorts: TypeAlias = Callable[[], Sequence[SerialPort]]


def find_usb_location(path: str, *, sys_folder: str = "/sys/class/tty") -> str | None:
    """Return the kernel's name for the USB socket of a port; None if the port is not on USB."""
    device = os.path.realpath(f"{sys_folder}/{path.rpartition('/')[2]}/device")
    for part in reversed(device.split("/")):
        if _USB_INTERFACE.fullmatch(part):
            return part
    return None
