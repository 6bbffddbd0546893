"""Sends datagrams by every interface that is given; one that is missing is opened when it has come."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable

from rostether.graph.ports import Level
from rostether.platform.multicast_socket import GroupAddress, open_sender

# An interface that could not be opened is tried again this often.
_REOPEN_S = 1.0


class DatagramSender:
    """Sends to one group or address; `report` gets a line when sending fails, and when it works again."""

    def __init__(self, address: GroupAddress, report: Callable[[Level, str], None]) -> None:
        self._address = address
        self._report = report
        self._sockets: dict[str, socket.socket | None] = dict.fromkeys(address.interfaces or ("",))
        self._retry_at_s: dict[str, float] = {}
        self._reported: set[str] = set()

    def send(self, datagram: bytes) -> bool:
        """Send by all interfaces; False if none could."""
        return max(self._send_by(interface, datagram) for interface in self._sockets)

    def close(self) -> None:
        """Close the sockets. Idempotent."""
        for interface, sock in self._sockets.items():
            if sock is not None:
                sock.close()
            self._sockets[interface] = None

    def _send_by(self, interface: str, datagram: bytes) -> bool:
        now_s = time.monotonic()
        if now_s < self._retry_at_s.get(interface, 0.0):
            return False
        try:
            sock = self._sockets[interface]
            if sock is None:
                self._retry_at_s[interface] = now_s + _REOPEN_S
                sock = self._sockets[interface] = open_sender(self._address, interface)
                del self._retry_at_s[interface]
            sock.sendto(datagram, (self._address.group, self._address.port))
        except BlockingIOError:
            return False
        except OSError as error:
            if interface not in self._reported:
                self._reported.add(interface)
                by = f" by {interface}" if interface else ""
                self._report(
                    Level.ERROR,
                    f"cannot send to {self._address}{by}: {error.strerror or error}; trying again. "
                    "~interface chooses the network interface",
                )
            return False
        if interface in self._reported:
            self._reported.remove(interface)
            self._report(Level.INFO, f"sending to {self._address} again")
        return True
