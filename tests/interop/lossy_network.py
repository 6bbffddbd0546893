"""Bad Wi-Fi on loopback: between senders and robots, datagrams are lost at random and others are late.

It works like an access point. Each robot has a separate port for the group; the answers of the robots, and
unicast to them, have the same faults.
"""

from __future__ import annotations

import asyncio
import contextlib
import random
import socket
from collections.abc import Callable, Sequence
from functools import partial

from msgspec.structs import replace

from rostether.platform.multicast_socket import GroupAddress, join_group, open_receiver, open_sender
from rostether.platform.robot_table import SocketAddress

_MAX_BYTES = 2048


class LossyNetwork:
    """Forwards the datagrams for the group `senders` to the groups `robots`, until the block ends."""

    def __init__(
        self, senders: GroupAddress, robots: Sequence[GroupAddress], *, loss: float, jitter_s: float
    ) -> None:
        self.loss = loss
        self._jitter_s = jitter_s
        self._random = random.Random(1)
        self._senders = senders
        self._robots = robots
        self._routes: dict[tuple[SocketAddress, GroupAddress], _Route] = {}
        self._sockets: list[socket.socket] = []
        # Every datagram to the group.
        self.sent: list[tuple[bytes, float]] = []

    def __enter__(self) -> LossyNetwork:
        group = open_receiver(self._senders)
        join_group(group, self._senders, self._senders.interfaces[0])
        self.add_reader(group, self._forward)
        return self

    def __exit__(self, *_: object) -> None:
        for sock in self._sockets:
            asyncio.get_running_loop().remove_reader(sock)
            sock.close()
        self._sockets.clear()

    def add_reader(self, sock: socket.socket, handle: Callable[[bytes, SocketAddress], None]) -> None:
        """Read a socket until the block ends."""
        self._sockets.append(sock)
        asyncio.get_running_loop().add_reader(sock, self._read, sock, handle)

    def deliver(self, send: Callable[[], object]) -> None:
        """Call `send` after a random time, or never."""
        if self._random.random() >= self.loss:
            delay_s = self._random.uniform(0, self._jitter_s)
            asyncio.get_running_loop().call_later(delay_s, self._send, send)

    def _send(self, send: Callable[[], object]) -> None:
        if self._sockets:
            with contextlib.suppress(OSError):
                send()

    def _read(self, sock: socket.socket, handle: Callable[[bytes, SocketAddress], None]) -> None:
        with contextlib.suppress(OSError):
            while True:
                handle(*sock.recvfrom(_MAX_BYTES))

    def _forward(self, datagram: bytes, sender: SocketAddress) -> None:
        self.sent.append((datagram, asyncio.get_running_loop().time()))
        for robot in self._robots:
            route = self._routes.get((sender, robot))
            if route is None:
                route = self._routes[sender, robot] = _Route(self, sender, robot)
            self.deliver(partial(route.to_robot.sendto, datagram, (robot.group, robot.port)))


class _Route:
    """Forwards datagrams from one sender to one robot, and the robot's datagrams to the sender."""

    def __init__(self, network: LossyNetwork, sender: SocketAddress, robot: GroupAddress) -> None:
        self._network = network
        self._sender = sender
        self._robot_address: SocketAddress | None = None
        self.to_robot = open_sender(robot, robot.interfaces[0])
        self._to_sender = open_sender(replace(robot, group="127.0.0.1"), "")
        network.add_reader(self.to_robot, self._forward_to_sender)
        network.add_reader(self._to_sender, self._forward_to_robot)

    def _forward_to_sender(self, datagram: bytes, address: SocketAddress) -> None:
        self._robot_address = address
        self._network.deliver(partial(self._to_sender.sendto, datagram, self._sender))

    def _forward_to_robot(self, datagram: bytes, _: SocketAddress) -> None:
        if self._robot_address is not None:
            self._network.deliver(partial(self.to_robot.sendto, datagram, self._robot_address))
