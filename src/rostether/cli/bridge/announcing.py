"""Announces by mDNS where boards can connect, while `serve` runs."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

from rostether.errors import ConfigError, TransportOpenError
from rostether.extras import install_command
from rostether.graph.ports import Level
from rostether.mechanisms.block_end import task_beside
from rostether.mechanisms.loopback import is_loopback
from rostether.transports.address import TcpAddress
from rostether.transports.address_parser import parse_address

if TYPE_CHECKING:
    from rostether.bridge.reporter import Reporter
    from rostether.transports.mdns import ListenerAnnouncement


def check_mdns(*, is_wanted: bool | None) -> bool:
    """Return whether to announce listeners by mDNS.

    With `is_wanted` None, they are announced if zeroconf is installed. Raises ConfigError if they must be
    announced and it is missing.
    """
    if is_wanted is False:
        return False
    is_there = find_spec("zeroconf") is not None
    if is_wanted and not is_there:
        raise ConfigError(f"--mdns needs zeroconf; run: {install_command('mdns')}; or omit --mdns")
    return is_there


def network_listeners(listening_on: Sequence[str]) -> list[TcpAddress]:
    """Return the listeners to announce: those for TCP without TLS that other machines can reach."""
    links = [parse_address(address) for address in listening_on]
    # Boards that find a listener by mDNS do not support TLS.
    plain = [link for link in links if isinstance(link, TcpAddress) and link.tls is None]
    return [link for link in plain if not is_loopback(link.host)]


@asynccontextmanager
async def announced(
    listening_on: Sequence[str], reporter: Reporter, *, is_wanted: bool | None
) -> AsyncIterator[None]:
    """Announce the listeners that are reachable from the network, until the end of the block.

    A failure is reported in one line, and serving continues. If --mdns was given (`is_wanted`), it is also
    reported that there is nothing to announce.
    """
    listeners = network_listeners(listening_on)
    if is_wanted and not listeners:
        reporter.report(
            Level.WARN,
            "--mdns announces nothing: no TCP listener without TLS is reachable from the network; add "
            "--listen 0.0.0.0 tcp://:11411",
        )
    if not listeners or not check_mdns(is_wanted=is_wanted):
        yield
        return
    announcements: list[ListenerAnnouncement] = []
    # Checking that the name is free takes a second; boards are served in the meantime.
    try:
        async with task_beside(_start(listeners, announcements, reporter)):
            yield
    finally:
        await asyncio.gather(*(each.close() for each in announcements), return_exceptions=True)


async def _start(
    listeners: Sequence[TcpAddress], announcements: list[ListenerAnnouncement], reporter: Reporter
) -> None:
    from rostether.transports.mdns import ListenerAnnouncement

    for listener in listeners:
        try:
            announcement = await ListenerAnnouncement.start(listener.host, listener.port)
        except TransportOpenError as error:
            reporter.report(Level.WARN, f"{error}; configure this machine's address on the boards instead")
            continue
        announcements.append(announcement)
        reporter.report(
            Level.INFO, f"Announced by mDNS as {announcement.name!r} (_rosserial._tcp, port {listener.port})"
        )
