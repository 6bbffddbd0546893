"""UDP sockets for multicast groups, IPv4 and IPv6; unicast addresses also work."""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import struct
import sys

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.mechanisms.text import show_endpoint
from rostether.transports.sockets import new_socket

REFERENCE_GROUP = "224.0.1.1"
REFERENCE_PORT = 12345

# The maximum payload of UDP over IPv4.
MAX_DATAGRAM_BYTES = 65_507

# IP_MULTICAST_ALL and IPV6_MULTICAST_ALL of Linux, which the module socket does not have.
_MULTICAST_ALL = {socket.AF_INET: (socket.IPPROTO_IP, 49), socket.AF_INET6: (socket.IPPROTO_IPV6, 29)}


class GroupAddress(Struct, frozen=True):
    """A group, a port, and the network interfaces to use: names, or IPv4 addresses.

    Without interfaces, the system's routes decide. `ttl` is the number of networks that a datagram may cross.
    """

    group: str = REFERENCE_GROUP
    port: int = REFERENCE_PORT
    interfaces: tuple[str, ...] = ()
    ttl: int = 1

    def checked(self) -> GroupAddress:
        """Return the address itself if its group is numeric. Raises ConfigError."""
        try:
            ipaddress.ip_address(self.group)
        except ValueError:
            raise ConfigError(
                f"{self.group!r:.200} is not a numeric IP address, such as 239.255.82.83"
            ) from None
        return self

    @property
    def family(self) -> socket.AddressFamily:
        """The family of the group's address."""
        return socket.AF_INET6 if ":" in self.group else socket.AF_INET

    @property
    def is_multicast(self) -> bool:
        """Whether the address is a multicast group, not a unicast address."""
        return ipaddress.ip_address(self.group).is_multicast

    def __str__(self) -> str:
        """Return address and port as one text."""
        return show_endpoint(self.group, self.port)


def open_sender(address: GroupAddress, interface: str) -> socket.socket:
    """Return a socket that sends on one interface, "" for the system's choice. Raises OSError."""
    with new_socket(address.family) as sock:
        if address.is_multicast and address.family == socket.AF_INET6:
            sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, address.ttl)
            if interface:
                index = socket.if_nametoindex(interface)
                sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, index)
        elif address.is_multicast:
            sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, address.ttl)
            if interface:
                request = _request(address.group, interface)
                sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, request)
    return sock


def open_receiver(address: GroupAddress) -> socket.socket:
    """Return a socket bound to the group, which `join_group` then joins. Raises OSError."""
    with new_socket(address.family) as sock:
        # Several programs of one machine may receive a group.
        if address.is_multicast:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # A socket bound to the group receives only its datagrams. Windows binds only to local addresses.
        # With a group of one link (ff02::1), it would be bound to one interface, until that is unplugged.
        is_of_link = bool(address.interfaces) and _is_of_link(address.group)
        is_wide = address.is_multicast and (is_of_link or sys.platform == "win32")
        if is_wide and sys.platform == "linux":
            sock.setsockopt(*_MULTICAST_ALL[address.family], 0)
        sock.bind(("" if is_wide else address.group, address.port))
    return sock


def open_unicast(address: GroupAddress) -> socket.socket | None:
    """Return a socket that receives unicast on the group's port, None if that is not possible or not needed.

    If several robots run on one machine, only the last one receives unicast. On Windows, the group's socket
    receives it.
    """
    if not address.is_multicast or sys.platform == "win32":
        return None
    with contextlib.suppress(OSError), new_socket(address.family) as sock:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if sys.platform == "linux":
            # Without this, the socket also receives the groups that other sockets have joined.
            sock.setsockopt(*_MULTICAST_ALL[address.family], 0)
        sock.bind(("", address.port))
        return sock
    return None


def join_group(sock: socket.socket, address: GroupAddress, interface: str) -> None:
    """Join the group, after leaving it if it was joined, so that switches get a new report.

    Raises OSError where the interface is missing or has no address.
    """
    if address.family == socket.AF_INET6:
        index = socket.if_nametoindex(interface) if interface else 0
        request = socket.inet_pton(socket.AF_INET6, address.group) + struct.pack("@I", index)
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_LEAVE_GROUP, request)
        sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, request)
        return
    request = _request(address.group, interface)
    with contextlib.suppress(OSError):
        sock.setsockopt(socket.IPPROTO_IP, socket.IP_DROP_MEMBERSHIP, request)
    sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, request)


def _is_of_link(group: str) -> bool:
    """Return whether an IPv6 group belongs to one link or one machine (ff02::1, ff01::1)."""
    return ":" in group and ipaddress.ip_address(group).exploded[3] in "12"


def _request(group: str, interface: str) -> bytes:
    """Return the structure ip_mreqn, or ip_mreq for an interface that is given by its address."""
    try:
        own = socket.inet_aton(interface) if interface.count(".") == 3 else None
    except OSError:
        own = None
    if own is not None or not interface:
        return socket.inet_aton(group) + (own or bytes(4))
    return struct.pack("@4s4si", socket.inet_aton(group), bytes(4), socket.if_nametoindex(interface))
