"""The addresses of this machine's network interfaces."""

from __future__ import annotations

import socket
import struct
import sys

# Linux: netdevice(7). The address begins 20 bytes into the answer.
_SIOCGIFADDR = 0x8915
_REQUEST = struct.Struct("16s24x")
_MAX_NAME_BYTES = 15


def interface_address(name: str) -> str | None:
    """Return the IPv4 address of an interface, None if it has none or does not exist. Only on Linux."""
    if sys.platform != "linux" or not 0 < len(name.encode()) <= _MAX_NAME_BYTES:
        return None
    import fcntl

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        try:
            answer = fcntl.ioctl(sock, _SIOCGIFADDR, _REQUEST.pack(name.encode()))
        except OSError:
            return None
    return socket.inet_ntoa(answer[20:24])


def interface_addresses() -> dict[str, str]:
    """Return the interfaces that reach other machines, with their IPv4 addresses."""
    found = {name: interface_address(name) for _, name in socket.if_nameindex()}
    return {name: address for name, address in found.items() if address and not address.startswith("127.")}
