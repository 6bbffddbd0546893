"""Serves the dashboard on joined graphs: its gateway, its page and its address."""

from __future__ import annotations

import asyncio
import errno
import io
import socket
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from msgspec import Struct

from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.cli.dashboard.view import View
from rostether.cli.gateway.foxglove import gateway_on, with_ros1_types
from rostether.cli.gateway.gateways import NodeNaming, Report, joined_as, report_reach
from rostether.cli.gateway.options import DEFAULT_ADDRESS, Encryption, read_encryption, read_listen_address
from rostether.cli.shell.output import write_line
from rostether.dashboard.authority_page import TRUST_PAGE_FILE, authority_files
from rostether.dashboard.map_tiles import MapTiles
from rostether.dashboard.page_files import load_page
from rostether.errors import TransportOpenError
from rostether.gateways.foxglove.settings import DEFAULT_PORT, FoxgloveSettings
from rostether.gateways.websocket.site import TILES, Site
from rostether.graph.ports import Graph, Level
from rostether.mechanisms.anonymous import anonymous_name
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.loopback import LOOPBACK, is_loopback
from rostether.mechanisms.text import show_endpoint
from rostether.ports.config_paths import recordings_folder
from rostether.transports.own_names import outward_address

if TYPE_CHECKING:
    from rostether.dashboard.recordings import Recordings
    from rostether.gateways.foxglove.gateway import FoxgloveGateway

NODE = "dashboard"
TELEOP_NODE = "web_teleop"

# The ports to try after the usual one: people can remember the addresses of a second and a third dashboard.
_NEXT_PORTS = 20
# Programs that start at the same time may choose the same port.
_PORT_TRIES = 5
_EVERYWHERE = ("", "0.0.0.0", "::")  # noqa: S104 - what was typed


class Dashboard(Struct, frozen=True):
    """A running dashboard; `url` and the `view_urls` of its panels contain the token if there is one."""

    gateway: FoxgloveGateway
    url: str
    view_urls: tuple[str, ...] = ()

    async def wait_ended(self) -> None:
        """Wait until its node has left the graph."""
        await self.gateway.wait_ended()


@asynccontextmanager
async def served_dashboard(
    settings: DashboardSettings, graphs: ServedGraphs, msg_paths: Sequence[Path], report: Report
) -> AsyncIterator[Dashboard]:
    """Serve the dashboard until the end of the block.

    Raises ConfigError, TransportOpenError if a given port is not free, GraphError if another node has the
    name.
    """
    host, port = read_listen_address(settings.address, 0)
    is_typed = settings.address != host and settings.address.strip("[]") != host
    async with AsyncExitStack() as stack:
        for tries_left in reversed(range(1 if is_typed else _PORT_TRIES)):
            if not is_typed:
                port = await asyncio.to_thread(_free_port, host, DEFAULT_PORT)
            try:
                dashboard = await stack.enter_async_context(
                    _served_at(host, port, settings, graphs, msg_paths, report)
                )
                break
            except TransportOpenError:
                # Another program has opened the port since the check.
                if not tries_left:
                    raise
        yield dashboard


@asynccontextmanager
async def _served_at(
    host: str,
    port: int,
    settings: DashboardSettings,
    graphs: ServedGraphs,
    msg_paths: Sequence[Path],
    report: Report,
) -> AsyncIterator[Dashboard]:
    from rostether.dashboard.recordings import Recordings
    from rostether.gateways.foxglove.gateway import DashboardParts
    from rostether.recording.files import Form, create_recording

    access = settings.access
    encryption = await asyncio.to_thread(read_encryption, access.tls, host)
    gateway_graph = with_ros1_types(graphs, msg_paths)
    is_ros2_alone = graphs.ros1 is None
    recordings = Recordings(
        settings.recordings or recordings_folder(),
        lambda: gateway_graph.join(anonymous_name("record")),
        lambda text: report(Level.INFO, f"{NODE}: {text}"),
        # ROS 2 programs read MCAP files with ROS 2 messages.
        partial(create_recording, form=Form.ROS2, types=graphs.types) if is_ros2_alone else create_recording,
    )
    map_metadata = {}
    tiles = await asyncio.to_thread(MapTiles, settings.tiles) if settings.tiles is not None else None
    if tiles is not None:
        map_metadata = {"tiles": f"{TILES}{{z}}/{{x}}/{{y}}", "tiles_max_zoom": str(tiles.max_zoom)}
    site = None
    if settings.has_page:
        site = await asyncio.to_thread(_load_site, encryption, recordings, tiles, settings.views)
    graph = await joined_as(
        gateway_graph, settings.node, settings.node.name_for(NODE, port, DEFAULT_PORT), report
    )
    teleop = NodeNaming().name_for(TELEOP_NODE, port, DEFAULT_PORT)
    served = FoxgloveSettings(
        host,
        port,
        name=socket.gethostname(),
        label=NODE,
        token=access.token,
        view_token=access.view_token,
        origins=access.origins,
        allow=access.allow,
        certificate=encryption.certificate,
        key=encryption.key,
        metadata={
            "rostether_version": version("rostether"),
            "recording_format": "mcap" if is_ros2_alone else "bag",
            # Pages recognize their own commands by this name.
            "teleop_node": f"{graph.node_name.rpartition('/')[0]}/{teleop}",
            **map_metadata,
        },
    )

    async def join_teleop() -> Graph:
        return await joined_as(gateway_graph, NodeNaming(namespace=settings.node.namespace), teleop, report)

    async with (
        closed_at_end(graph),
        gateway_on(
            graph,
            gateway_graph,
            served,
            report,
            DashboardParts(site, join_teleop, recordings, settings.boards),
        ) as gateway,
    ):
        url = page_url(host, gateway.port, access.token, is_encrypted=bool(access.tls))
        page = url.partition("#")[0].rstrip("/")
        view_urls = tuple(f"{page}/#{view.fragment(access.token)}" for view in settings.views)
        if settings.has_page:
            report(Level.INFO, f"Dashboard: {url}")
            if access.view_token:
                view_url = page_url(host, gateway.port, access.view_token, is_encrypted=bool(access.tls))
                report(Level.INFO, f"Dashboard, view only: {view_url}")
            if encryption.authority is not None:
                report(
                    Level.INFO,
                    f"Browsers warn until a device trusts this machine; see {page}/{TRUST_PAGE_FILE}",
                )
            for view, view_url in zip(settings.views, view_urls, strict=True):
                report(Level.INFO, f"Dashboard, {view.panel or 'overview'}: {view_url}")
            if not is_loopback(host) and sys.stdout.isatty():
                write_line(qr_code(url))
        else:
            report(Level.INFO, f"dashboard: the gateway without the page is at {gateway.url}")
        report_reach("dashboard", host, gateway.port, access.token, settings.remote_option, report)
        yield Dashboard(gateway, url, view_urls)


def page_url(host: str, port: int, token: str = "", *, is_encrypted: bool = False) -> str:
    """Return the address to open in a browser; the token is in the fragment, which browsers do not send."""
    if host == DEFAULT_ADDRESS:
        host = LOOPBACK
    elif host in _EVERYWHERE:
        # Phones often cannot resolve this machine's name, but can use its address.
        host = outward_address() or socket.gethostname()
    fragment = f"#token={quote(token, safe='')}" if token else ""
    scheme = "https" if is_encrypted else "http"
    return f"{scheme}://{show_endpoint(host, port)}/{fragment}".removesuffix("/")


def _load_site(
    encryption: Encryption, recordings: Recordings, tiles: MapTiles | None, views: Sequence[View]
) -> Site:
    more = {name: content for view in views for name, content in view.files.items()}
    if encryption.authority is not None:
        more |= authority_files(encryption.authority, socket.gethostname())
    return load_page(more, recordings.find, tiles)


def _free_port(host: str, wanted: int) -> int:
    """Return the requested port, else the next free one, else 0 for any."""
    name = LOOPBACK if host == DEFAULT_ADDRESS else host
    family = socket.AF_INET6 if ":" in name else socket.AF_INET
    for port in range(wanted, wanted + _NEXT_PORTS):
        try:
            with socket.create_server((name, port), family=family):
                return port
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                # The gateway reports the error of the address.
                return wanted
    return 0


def qr_code(text: str) -> str:
    """Return a text as a QR code of half-block characters."""
    import segno

    lines = io.StringIO()
    segno.make(text, micro=False, error="l").terminal(lines, compact=True, border=2)
    return lines.getvalue().rstrip("\n")
