"""Opens the transports of link addresses; each kind is imported when it is first needed."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from typing import TYPE_CHECKING

from rostether.errors import ConfigError
from rostether.transports.address import (
    Address,
    PtyAddress,
    SerialAddress,
    SimAddress,
    TcpAddress,
    UdpAddress,
    WebAddress,
    XbeeAddress,
)
from rostether.transports.address_parser import parse_address
from rostether.transports.serial_port import SerialPort
from rostether.transports.transport import Listener, Transport

if TYPE_CHECKING:
    from rostether.transports.board_keys import BoardKeys
    from rostether.transports.peers import PeerEntry
    from rostether.transports.web_boards import WebBoards


def list_serial_ports() -> list[SerialPort]:
    """Return the current serial ports, sorted by path."""
    from rostether.transports import serial  # imports serialx

    return serial.list_ports()


async def open_transport(address: Address | str) -> Transport:
    """Open one link. Raises ConfigError, TransportOpenError, TransportTimeoutError."""
    if isinstance(address, str):
        address = parse_address(address)
    match address:
        case SerialAddress():
            from rostether.transports.serial import open_serial

            return await open_serial(address)
        case PtyAddress():
            from rostether.transports.pty import open_pty

            return open_pty(address)
        case TcpAddress(connect=True):
            from rostether.transports.tcp import connect_tcp

            return await connect_tcp(address)
        case UdpAddress(connect=True):
            from rostether.transports.udp import connect_udp

            return await connect_udp(address)
        case SimAddress():
            raise ConfigError(
                f"{address} is a simulated board; `rostether serve {shlex.quote(str(address))}` starts it"
            )
        case WebAddress():
            raise ConfigError(f"{address} is for `rostether serve --dashboard`: its page connects the boards")
        case _:
            raise ConfigError(f"{address} accepts many devices; add ?connect=yes to connect to one")


async def listen(
    address: Address | str,
    on_transport: Callable[[Transport], None],
    *,
    connections: int | None = None,
    connections_per_host: int | None = None,
    board_keys: BoardKeys | None = None,
    entry: PeerEntry | None = None,
    web_boards: WebBoards | None = None,
) -> Listener:
    """Listen on an address for which `listens` is true; call back with each new link.

    `connections` limits the open links, `connections_per_host` the TCP connections of one host (None: the
    default of the kind of link). `board_keys` are the keys of individual boards. `entry` decides which
    senders of datagrams become links. `web_boards` are the boards that the dashboard's pages connect. Raises
    the same errors as `open_transport`.
    """
    if isinstance(address, str):
        address = parse_address(address)
    match address:
        case TcpAddress(connect=False):
            from rostether.transports.board_keys import NO_KEYS
            from rostether.transports.descriptors import boards_that_fit
            from rostether.transports.tcp import MAX_CONNECTIONS, MAX_CONNECTIONS_PER_HOST, TcpListener

            return await TcpListener.start(
                address,
                on_transport,
                max_connections=connections or boards_that_fit(MAX_CONNECTIONS),
                max_connections_per_host=connections_per_host or MAX_CONNECTIONS_PER_HOST,
                board_keys=board_keys or NO_KEYS,
            )
        case UdpAddress(connect=False):
            from rostether.transports.peers import MAX_PEERS
            from rostether.transports.udp import UdpListener

            return await UdpListener.start(
                address, on_transport, max_peers=connections or MAX_PEERS, entry=entry
            )
        case XbeeAddress():
            from rostether.transports.serial import open_serial
            from rostether.transports.xbee.listener import XbeeListener

            return await XbeeListener.start(
                address, on_transport, open_serial=open_serial, call=entry.call if entry is not None else b""
            )
        case WebAddress():
            if web_boards is None:
                raise ConfigError(f"{address} needs --dashboard: its page connects the boards")
            web_boards.listen(address, on_transport)
            return web_boards
        case _:
            raise ConfigError(f"{address} is one device; give an address that listens, such as tcp://:11411")
