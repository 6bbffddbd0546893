"""The serial ports of a machine, as the search for boards sees and opens them."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence

from msgspec import Struct

from rostether.bridge.ports.port_probe import TunableTransport
from rostether.ports.port_locks import find_port_user
from rostether.ports.port_watch import DEVICE_FOLDER
from rostether.transports.address import SerialAddress
from rostether.transports.opening import list_serial_ports
from rostether.transports.serial_port import ListPorts


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
