"""Options of sockets, and explanations of their errors, for TCP, UDP and the servers of ROS 1."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import re
import socket
from collections.abc import AsyncIterator, Callable, Collection, Iterator
from weakref import WeakKeyDictionary

from rostether.errors import TransportOpenError
from rostether.mechanisms.loopback import LOOPBACK
from rostether.mechanisms.text import show_endpoint

# A working name server answers within this time.
RESOLVE_LIMIT_S = 5.0
# A board without power does not close its connection: probe after 5 s of silence, 3 times in 6 s.
_KEEPALIVE_IDLE_S = 5
_KEEPALIVE_INTERVAL_S = 2
_KEEPALIVE_PROBES = 3
# The same for a board that disappeared while data was being sent to it.
_UNACKNOWLEDGED_LIMIT_MS = 11_000
# Data for a slow board waits in this process, where it is counted and old commands can be dropped; the kernel
# keeps enough unsent data to fill the line until the process wakes up.
_UNSENT_BYTES = 16 * 1024

# The connections that the kernel keeps while the event loop is busy: after a restart, all boards and nodes
# connect at once. Without room, a peer tries again a second later. Only waiting connections need memory.
_BACKLOG = 1024

# About 30 frames of 4 KiB: with smaller reads, system calls take a tenth of the time.
READ_BYTES = 128 * 1024

# By event loop: a loop reads one connection at a time, and each read is copied before the next one.
_read_buffers: WeakKeyDictionary[asyncio.AbstractEventLoop, memoryview] = WeakKeyDictionary()

# Options are given by name, because each system lacks some of them; on macOS, TCP_KEEPIDLE is TCP_KEEPALIVE.
_STREAM_OPTIONS = (
    (socket.IPPROTO_TCP, "TCP_NODELAY", 1),
    (socket.SOL_SOCKET, "SO_KEEPALIVE", 1),
    (socket.IPPROTO_TCP, "TCP_KEEPIDLE", _KEEPALIVE_IDLE_S),
    (socket.IPPROTO_TCP, "TCP_KEEPALIVE", _KEEPALIVE_IDLE_S),
    (socket.IPPROTO_TCP, "TCP_KEEPINTVL", _KEEPALIVE_INTERVAL_S),
    (socket.IPPROTO_TCP, "TCP_KEEPCNT", _KEEPALIVE_PROBES),
    (socket.IPPROTO_TCP, "TCP_USER_TIMEOUT", _UNACKNOWLEDGED_LIMIT_MS),
    (socket.IPPROTO_TCP, "TCP_NOTSENT_LOWAT", _UNSENT_BYTES),
)

# asyncio's texts of a failed connection, to several addresses and to one.
_SEVERAL_FAILED = "Multiple exceptions: "
_CONNECT_FAILED = "Connect call failed"
_ERROR_NUMBER = re.compile(r"\[Errno (\d+)\]")


@contextlib.contextmanager
def new_socket(family: int, kind: int = socket.SOCK_DGRAM, protocol: int = -1) -> Iterator[socket.socket]:
    """Yield a new socket that does not block; it is closed if the block raises OSError."""
    sock = socket.socket(family, kind, protocol)
    try:
        sock.setblocking(False)
        yield sock
    except OSError:
        sock.close()
        raise


def tune_stream(sock: socket.socket) -> None:
    """Send immediately, buffer little, and detect within eleven seconds a peer that has disappeared."""
    for level, name, value in _STREAM_OPTIONS:
        option = getattr(socket, name, None)
        if option is not None:
            with contextlib.suppress(OSError):
                sock.setsockopt(level, option, value)


def limit_unsent(transport: asyncio.BaseTransport, limit_bytes: int) -> None:
    """Keep data for a slow peer in this process, where it can be dropped: the kernel would keep megabytes."""
    opened, option = transport.get_extra_info("socket"), getattr(socket, "TCP_NOTSENT_LOWAT", None)
    if opened is not None and option is not None:
        with contextlib.suppress(OSError):
            opened.setsockopt(socket.IPPROTO_TCP, option, limit_bytes)


def read_buffer() -> memoryview:
    """Return the running event loop's buffer for reads of connections, `READ_BYTES` long."""
    loop = asyncio.get_running_loop()
    buffer = _read_buffers.get(loop)
    if buffer is None:
        buffer = _read_buffers[loop] = memoryview(bytearray(READ_BYTES))
    return buffer


async def start_server(
    make_protocol: Callable[[], asyncio.BaseProtocol], host: str | None, port: int, *, accepted_at_once: int
) -> asyncio.Server:
    """Listen on a TCP port; many more connections than are accepted in one turn of the loop may wait.

    Raises OSError in the system's form, with errno and strerror, and socket.gaierror for a host without an
    address.
    """
    async with _system_bind_errors(host, port):
        # asyncio's `backlog` is also the number of connections that it accepts in one turn.
        server = await asyncio.get_running_loop().create_server(
            make_protocol, host, port, backlog=accepted_at_once, start_serving=False
        )
        # `create_server` itself would leave the server open if it was canceled while it starts to serve.
        try:
            await server.start_serving()
        except BaseException:
            server.close()
            raise
    for listener in server.sockets:
        with (
            contextlib.suppress(OSError),
            socket.fromfd(listener.fileno(), listener.family, listener.type) as sock,
        ):
            sock.listen(_BACKLOG)
    return server


@contextlib.asynccontextmanager
async def _system_bind_errors(host: str | None, port: int) -> AsyncIterator[None]:
    """Raise the errors of a TCP bind inside the block in the system's form, with errno and strerror.

    asyncio words these errors differently in each Python, and since 3.13 gives a foreign address no errno.
    Raises OSError, socket.gaierror for a host that has no address.
    """
    try:
        yield
    except socket.gaierror:
        raise
    except OSError as error:
        if error.errno:
            raise OSError(error.errno, os.strerror(error.errno)) from error
        await _try_bind(host, port)
        raise


async def _try_bind(host: str | None, port: int) -> None:
    """Bind once to each address of the host without asyncio. Raises the system's OSError."""
    sockaddrs = await asyncio.get_running_loop().getaddrinfo(
        host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )
    for family, kind, protocol, _, sockaddr in sockaddrs:
        with socket.socket(family, kind, protocol) as sock:
            sock.bind(sockaddr)


def explain_bind_error(scheme: str, host: str, port: int, error: OSError) -> TransportOpenError:
    """Return why listening on an address is impossible, and what to use instead."""
    shown_host = "" if host == LOOPBACK else host
    if error.errno == errno.EADDRINUSE:
        return TransportOpenError(
            f"port {port} is already in use on {host}; stop the program that listens there "
            f"or choose another port with {scheme}://{shown_host}:PORT"
        )
    if error.errno == errno.EADDRNOTAVAIL:
        return TransportOpenError(
            f"{host} is not an address of this machine; write {scheme}://0.0.0.0:{port} to listen on all its"
            " addresses"
        )
    if error.errno == errno.EACCES:
        return TransportOpenError(
            f"port {port} is reserved for the system; choose one above 1023 with {scheme}://{shown_host}:PORT"
        )
    return TransportOpenError(
        f"cannot listen on {show_endpoint(host, port)}: {explain_reason(error)}; check the host"
    )


def explain_connect_error(sockaddr: str, error: OSError) -> TransportOpenError:
    """Return why a peer cannot be reached."""
    reason = explain_reason(error)
    if isinstance(error, ConnectionRefusedError) or reason == os.strerror(errno.ECONNREFUSED):
        return TransportOpenError(f"no program listens on {sockaddr}; start it, or correct the port")
    if isinstance(error, socket.gaierror):
        return TransportOpenError(f"the host of {sockaddr} is unknown; check its name, or write its address")
    return TransportOpenError(f"cannot reach {sockaddr}: {reason}; check the address and the network")


def explain_reason(error: Exception) -> str:
    """Return the text of an error, without its number and file name.

    For failed connections it is the system's text, because asyncio's names an internal call.
    """
    text: str = getattr(error, "strerror", None) or str(error)
    numbers = [int(each) for each in _ERROR_NUMBER.findall(text)] if text.startswith(_SEVERAL_FAILED) else []
    if isinstance(error, OSError) and error.errno and text.startswith(_CONNECT_FAILED):
        numbers = [error.errno]
    if numbers:
        # A machine that refuses was reached. Otherwise, the last address is most often the IPv4 address.
        return os.strerror(errno.ECONNREFUSED if errno.ECONNREFUSED in numbers else numbers[-1])
    return text or type(error).__name__


async def close_servers(servers: Collection[asyncio.Server]) -> None:
    """Stop listening. Connections that were accepted just before still reach their protocols, which end them.

    asyncio gives a connection its transport one turn of the loop after it has accepted it. If the server is
    closed in between, no transport can be made, and the socket is never closed.
    """
    loop = asyncio.get_running_loop()
    for server in servers:
        for listener in server.sockets:
            # Windows' loop has no readers; it makes the transport immediately.
            with contextlib.suppress(NotImplementedError):
                loop.remove_reader(listener.fileno())
    try:
        await asyncio.sleep(0)
    finally:
        for server in servers:
            server.close()
