"""Sends datagrams on all given interfaces; opens a missing interface when it appears."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import Callable

from rostether.graph.ports import Level, Report
from rostether.platform.multicast_socket import GroupAddress, open_sender
from rostether.platform.robot_table import SocketAddress

# The interval between attempts to open an interface.
_REOPEN_S = 1.0

# The number of answers to read before other tasks run, and the size of the largest valid answer.
_BURST = 100
_MAX_ANSWER_BYTES = 2048


class DatagramSender:
    """Sends to one group or address; `report` gets a line when sending fails, and when it works again.

    `on_datagram` gets the datagrams that arrive at its sockets; without it, nothing is read.
    """

    def __init__(
        self,
        address: GroupAddress,
        report: Report,
        on_datagram: Callable[[bytes, SocketAddress], None] | None = None,
    ) -> None:
        self._on_datagram = on_datagram
        self._address = address
        self._report = report
        self._sockets: dict[str, socket.socket | None] = dict.fromkeys(address.interfaces or ("",))
        self._retry_at_s: dict[str, float] = {}
        self._reported: set[str] = set()

    def send(self, datagram: bytes) -> bool:
        """Send on all interfaces; return False if none could send."""
        return max(self._send_by(interface, datagram) for interface in self._sockets)

    def send_to(self, datagram: bytes, address: SocketAddress) -> None:
        """Send to one machine, if a socket is open and the system accepts it now."""
        sock = next((each for each in self._sockets.values() if each is not None), None)
        if sock is not None:
            with contextlib.suppress(OSError):
                sock.sendto(datagram, address)

    def close(self) -> None:
        """Close the sockets. Idempotent."""
        for interface in self._sockets:
            self._close(interface)

    def _close(self, interface: str) -> None:
        if (sock := self._sockets[interface]) is not None:
            if self._on_datagram is not None:
                asyncio.get_running_loop().remove_reader(sock)
            sock.close()
        self._sockets[interface] = None

    def _read(self, sock: socket.socket, on_datagram: Callable[[bytes, SocketAddress], None]) -> None:
        for _ in range(_BURST):
            try:
                datagram, address = sock.recvfrom(_MAX_ANSWER_BYTES)
            except BlockingIOError:
                return
            except OSError:
                # Systems may report here that no program listens at a unicast address.
                continue
            on_datagram(datagram, address)

    def _send_by(self, interface: str, datagram: bytes) -> bool:
        now_s = time.monotonic()
        if now_s < self._retry_at_s.get(interface, 0.0):
            return False
        try:
            sock = self._sockets[interface]
            if sock is None:
                self._retry_at_s[interface] = now_s + _REOPEN_S
                sock = self._sockets[interface] = open_sender(self._address, interface)
                if self._on_datagram is not None:
                    asyncio.get_running_loop().add_reader(sock, self._read, sock, self._on_datagram)
                del self._retry_at_s[interface]
            sock.sendto(datagram, (self._address.group, self._address.port))
        except BlockingIOError:
            return False
        except OSError as error:
            # The interface may be gone. A new interface with the same name needs a new socket.
            self._close(interface)
            if interface not in self._reported:
                self._reported.add(interface)
                by = f" by {interface}" if interface else ""
                self._report(
                    Level.ERROR,
                    f"cannot send to {self._address}{by}: {error.strerror or error}; trying again. "
                    "~interface (--interface) chooses the network interface",
                )
            return False
        if interface in self._reported:
            self._reported.remove(interface)
            self._report(Level.INFO, f"sending to {self._address} again")
        return True
