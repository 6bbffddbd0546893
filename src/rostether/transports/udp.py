"""UDP: one transport for each peer address behind one socket, or a socket connected to one peer.

A datagram is a piece of the byte stream, and may end anywhere. A session writes whole frames: they are sent
as one datagram if they fit, otherwise cut at the datagram's limit, because the reader joins datagrams. A lost
datagram damages the frames of which it contained parts; their checksums then fail.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Callable, Iterator
from typing import Any, Protocol, TypeAlias, cast

from rostether.errors import TransportTimeoutError
from rostether.mechanisms.text import show_endpoint
from rostether.transports.address import UdpAddress
from rostether.transports.allow_list import AllowList
from rostether.transports.peers import MAX_PEERS, PeerEntry, PeerTable, PeerTransport, SharedMedium
from rostether.transports.sockets import (
    RESOLVE_LIMIT_S,
    explain_bind_error,
    explain_connect_error,
    new_socket,
)
from rostether.transports.transport import Transport

# Ethernet's 1500, minus IPv6 and UDP headers (48) and those of tunnels: datagrams are never fragmented.
MAX_DATAGRAM_BYTES = 1400
# A burst of all boards during the processing of one chunk; the default holds 200 small datagrams.
_RECEIVE_BUFFER_BYTES = 1024 * 1024
# A network that accepts nothing must not fill the memory; datagrams beyond this are dropped.
_SEND_LIMIT_BYTES = 1024 * 1024

_Peer: TypeAlias = tuple[Any, ...]  # (host, port) of IPv4, (host, port, flow, scope) of IPv6


def split_datagrams(data: bytes | bytearray | memoryview) -> Iterator[bytes]:
    """Split bytes into datagrams of at most MAX_DATAGRAM_BYTES, as few as possible."""
    for start in range(0, len(data), MAX_DATAGRAM_BYTES):
        yield bytes(data[start : start + MAX_DATAGRAM_BYTES])


class _DatagramWire(Protocol):
    """The methods of asyncio's datagram transports, some of which its stubs lack."""

    def sendto(self, data: bytes, addr: _Peer | None = None) -> None: ...

    def get_write_buffer_size(self) -> int: ...

    def is_closing(self) -> bool: ...

    def close(self) -> None: ...


class _DatagramSocket(asyncio.DatagramProtocol):
    def __init__(self) -> None:
        self.peers: PeerTable[_Peer]
        self._wire: _DatagramWire | None = None
        self._closed = asyncio.get_running_loop().create_future()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._wire = cast(_DatagramWire, transport)

    def connection_lost(self, exc: Exception | None) -> None:
        if not self._closed.done():
            self._closed.set_result(None)

    def error_received(self, exc: Exception) -> None:
        """Ignore "port unreachable": a board that restarts sends it, and returns a moment later."""

    def pause_writing(self) -> None:
        self.peers.pause_writing()

    def resume_writing(self) -> None:
        self.peers.resume_writing()

    def send(self, peer: _Peer | None, data: bytes | bytearray | memoryview) -> None:
        if self._wire is None or self._wire.is_closing():
            return
        for datagram in split_datagrams(data):
            if self._wire.get_write_buffer_size() < _SEND_LIMIT_BYTES:
                self._wire.sendto(datagram, peer)

    def write_buffer_bytes(self) -> int:
        return self._wire.get_write_buffer_size() if self._wire is not None else 0

    def _medium(
        self, name: str, send: Callable[[_Peer, bytes | bytearray | memoryview], None]
    ) -> SharedMedium[_Peer]:
        return SharedMedium(
            name,
            send=send,
            show=_show_peer,
            write_buffer_bytes=lambda _peer: self.write_buffer_bytes(),
            host_of=lambda peer: peer[0],
        )

    def close_wire(self) -> None:
        if self._wire is not None:
            self._wire.close()


class UdpListener(_DatagramSocket):
    """Receives from boards, and creates a transport for each peer address; created by `start`."""

    def __init__(
        self,
        on_transport: Callable[[Transport], None],
        allow: AllowList,
        max_peers: int,
        entry: PeerEntry | None,
    ) -> None:
        super().__init__()
        self._allow = allow
        self.address = ""
        self.peers = PeerTable(
            self._medium("udp listener", self.send),
            on_transport,
            max_peers=max_peers,
            entry=entry,
        )

    @classmethod
    async def start(
        cls,
        address: UdpAddress,
        on_transport: Callable[[Transport], None],
        *,
        max_peers: int = MAX_PEERS,
        entry: PeerEntry | None = None,
    ) -> UdpListener:
        """Listen; `entry` decides which senders become peers (None: all).

        Raises TransportOpenError if the port is in use or the host is not an address of this machine.
        """
        listener = cls(on_transport, AllowList(address.allow), max_peers, entry)
        try:
            family, sockaddr = await _resolve(address.host, address.port)
            sock = _make_socket(family, local=sockaddr)
        except OSError as error:
            raise explain_bind_error("udp", address.host, address.port, error) from error
        await asyncio.get_running_loop().create_datagram_endpoint(lambda: listener, sock=sock)
        return listener

    async def close(self) -> None:
        """Stop listening and end all its transports. Idempotent."""
        self.peers.end_all(None)
        self.close_wire()
        await asyncio.shield(self._closed)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the bound socket."""
        super().connection_made(transport)
        self.address = f"udp://{show_endpoint(*transport.get_extra_info('sockname')[:2])}"

    def datagram_received(self, data: bytes, addr: _Peer) -> None:
        """Deliver a datagram to its peer's transport."""
        if self._allow.allows(addr[0]):
            self.peers.receive(addr, data)
        else:
            self.peers.refusals.refuse(_show_peer(addr), "its address is not in allow=")


class _UdpClient(_DatagramSocket):
    """A socket connected to one peer; the peer's transport owns it."""

    def __init__(self) -> None:
        super().__init__()
        self.peers = PeerTable(
            self._medium("udp client", lambda _peer, data: self.send(None, data)),
            lambda _transport: None,
            on_forget=lambda _peer: self.close_wire(),
        )
        self.only_peer: PeerTransport[_Peer] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.only_peer = self.peers.add(transport.get_extra_info("peername"), expires=False)

    def datagram_received(self, data: bytes, addr: _Peer) -> None:
        if self.only_peer is not None:
            self.only_peer.deliver(data)


async def connect_udp(address: UdpAddress) -> Transport:
    """Create a socket that is connected to one peer only.

    Raises TransportOpenError, TransportTimeoutError.
    """
    endpoint = show_endpoint(address.host, address.port)
    try:
        async with asyncio.timeout(RESOLVE_LIMIT_S):
            family, remote = await _resolve(address.host, address.port)
    except TimeoutError as error:
        raise TransportTimeoutError(
            f"the name of {endpoint} was not found within {RESOLVE_LIMIT_S:g} s; write its numeric address"
        ) from error
    except OSError as error:
        raise explain_connect_error(endpoint, error) from error
    # Any address of this machine: a connected socket receives only from its peer.
    any_host = "::" if family == socket.AF_INET6 else "0.0.0.0"  # noqa: S104
    try:
        sock = _make_socket(family, local=(any_host, address.bind))
    except OSError as error:
        raise explain_bind_error("udp", any_host, address.bind, error) from error
    try:
        sock.connect(remote)
    except OSError as error:
        sock.close()
        raise explain_connect_error(endpoint, error) from error
    _, client = await asyncio.get_running_loop().create_datagram_endpoint(_UdpClient, sock=sock)
    assert client.only_peer is not None
    return client.only_peer


async def _resolve(host: str, port: int) -> tuple[int, _Peer]:
    """Return the first address of a host, with its family."""
    found = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    family, _, _, _, sockaddr = found[0]
    return family, sockaddr


def _make_socket(family: int, *, local: _Peer) -> socket.socket:
    """Bind a socket without asyncio, because event loops report errors differently."""
    with new_socket(family) as sock:
        sock.bind(local)
        with contextlib.suppress(OSError):  # the system's own limit may be lower
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
    return sock


def _show_peer(peer: _Peer) -> str:
    return f"udp {show_endpoint(peer[0], peer[1])}"
