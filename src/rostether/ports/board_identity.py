"""Identifies the board at the other end of a link, even if it returns on another port."""

from __future__ import annotations

from msgspec import Struct

# Default serial numbers of adapters: every CP2102 has 0001. Two such boards would be confused.
_NO_SERIAL_NUMBERS = frozenset({"0001", "001", "1", "123456", "12345678", "123456789", "0123456789"})


class BoardIdentity(Struct, frozen=True, kw_only=True):
    """The identifying properties of a board; those that its kind of link does not have are None.

    `port` is the serial port's path, `usb_location` its USB socket, `usb_interface` the number of its
    interface if one device has several ports, `address` a network address without the port, `psk` and
    `certificate` the files of the key and the certificate with which it has authenticated.
    """

    usb_id: str | None = None
    serial_number: str | None = None
    usb_location: str | None = None
    usb_interface: int | None = None
    port: str | None = None
    address: str | None = None
    psk: str | None = None
    certificate: str | None = None

    @property
    def own_serial_number(self) -> str | None:
        """The USB serial number if it is unique to the board."""
        number = (self.serial_number or "").strip()
        return number if number and number not in _NO_SERIAL_NUMBERS and number.strip("0") else None

    @property
    def key(self) -> str:
        """The key for stored data about the board: its serial number, else its socket, port or address."""
        interface = f"/{self.usb_interface}" if self.usb_interface else ""
        if self.own_serial_number is not None:
            return f"usb {self.usb_id or ''} {self.own_serial_number}{interface}"
        if self.usb_location is not None:
            # Another kind of device in the same socket is another board.
            return f"socket {self.usb_location} {self.usb_id or ''}"
        if self.address is not None:
            return f"net {self.address}"
        return f"port {self.port or ''}"
