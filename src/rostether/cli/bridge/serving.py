"""Serves boards on a ROS graph; shared by `serve`, `serial-node` and `demo`."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, TypeGuard

from msgspec.structs import replace

from rostether.cli.shell.library_logs import show_library_logs
from rostether.errors import ConfigError
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.loopback import LOOPBACK, is_loopback
from rostether.ros1.environment import RosEnvironment
from rostether.transports.address import Address, TcpAddress, UdpAddress, WebAddress
from rostether.transports.address_advice import check_typed_port
from rostether.transports.address_parser import parse_address
from rostether.transports.descriptors import shortage
from rostether.transports.opening import list_serial_ports

if TYPE_CHECKING:
    import click

    from rostether.bridge.reporter import Reporter
    from rostether.bridge.supervisor import Supervisor
    from rostether.transports.web_boards import WebBoards


def check_addresses(_ctx: click.Context, _param: click.Parameter, texts: tuple[str, ...]) -> tuple[str, ...]:
    """Return link addresses, unchanged. Raises ConfigError."""
    for text in texts:
        parse_address(text)
    return texts


def read_links(text: str, hosts: Sequence[str] = (LOOPBACK,), allowed: tuple[str, ...] = ()) -> list[Address]:
    """Return the links of a link address, several for a listener without a host.

    ROS_IP and ROS_HOSTNAME do not allow boards from the network: scripts set them for the graph. Raises
    ConfigError, for example for a mistyped serial port.

    Args:
        text: The link address.
        hosts: The hosts of a listener without a host, from --listen.
        allowed: The networks whose boards a listener without `allow=` accepts, from --allow.
    """
    link = parse_address(text)
    check_typed_port(link, list_serial_ports)
    if not _is_listener(link):
        return [link]
    link = replace(link, allow=link.allow or allowed)
    return [replace(link, host=host) for host in hosts] if "://:" in text else [link]


def _is_listener(link: Address) -> TypeGuard[TcpAddress | UdpAddress]:
    return isinstance(link, TcpAddress | UdpAddress) and link.listens


def read_web_boards(links: list[Address], *, is_served: bool, is_refused: bool) -> WebBoards | None:
    """Return the boards that pages of the dashboard connect, None if there can be none.

    The link of these boards is added to `links` if it is missing. Raises ConfigError for a link that cannot
    be served.
    """
    typed = [link for link in links if isinstance(link, WebAddress)]
    if len(typed) > 1:
        raise ConfigError("web: is given twice; give it once")
    if typed and is_refused:
        raise ConfigError(
            "web: serves the boards of pages, but --no-web-boards refuses them; give only one of them"
        )
    if typed and not is_served:
        raise ConfigError("web: needs --dashboard, whose page connects the boards")
    if not is_served or is_refused:
        return None
    from rostether.transports.web_boards import WebBoards

    if not typed:
        links.append(WebAddress())
    return WebBoards()


def loopback_lines(
    environment: RosEnvironment | None, links: Sequence[Address], *, consent: str = "--listen 0.0.0.0"
) -> list[str]:
    """Return a line for each listener that only this machine can reach, and one for a master elsewhere.

    `environment` is that of ROS 1, None without ROS 1; `consent` is what to add for boards on the network.
    """
    listeners = list(filter(_is_listener, links))
    wide = {(type(link), link.port) for link in listeners if not is_loopback(link.host)}
    lines = [
        f"{link} accepts boards on this machine only; add {consent} for boards on the network"
        for link in listeners
        if (type(link), link.port) not in wide
    ]
    if (
        environment is not None
        and environment.listens_on_loopback_only
        and not environment.master.is_loopback
    ):
        lines.append(
            "the master is on another machine, whose nodes cannot connect to this one; add --listen "
            "0.0.0.0 or set ROS_IP to this machine's address"
        )
    return lines


def shortage_lines(connections: int | None, links: Sequence[Address]) -> list[str]:
    """Return a warning if `connections` boards on each listener would need too many open files.

    `connections` is from --limit; without it (None), listeners accept only as many boards as files permit.
    """
    line = shortage((connections or 0) * sum(map(_is_listener, links)))
    return [] if line is None else [line]


@asynccontextmanager
async def serving(
    supervisor: Supervisor, addresses: Sequence[Address], reporter: Reporter
) -> AsyncIterator[None]:
    """Serve boards as nodes; the end of the block stops them and leaves the graph.

    `reporter` also gets what rostether's packages and asyncio log. Raises TransportOpenError for an address
    that cannot be listened on, InvalidNameError.
    """
    show_library_logs(reporter.report)
    async with closed_at_end(supervisor):
        await supervisor.start(addresses)
        yield
