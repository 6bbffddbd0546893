"""`rostether dashboard`: the robot in a browser."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import click
from msgspec.structs import replace

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.dashboard.served import Dashboard, served_dashboard
from rostether.cli.dashboard.settings import DashboardSettings
from rostether.cli.dashboard.view import PANELS, has_browser, open_browser, read_view
from rostether.cli.gateway.gateways import Report, read_gateway_arguments, serve_gateway
from rostether.cli.gateway.options import DEFAULT_ADDRESS, GatewayOptions, viewer_access_options
from rostether.cli.shell.option_group import EXISTING_FILE, flag, option, option_group
from rostether.cli.shell.verbs import verb


@dataclass(frozen=True, slots=True)
class DashboardOptions:
    """The options of `dashboard`."""

    port: int | None = option(
        "-p --port PORT",
        "Port of the page (default: the next free one from 8765).",
        type=click.IntRange(0, 65535),
    )
    listen: str | None = option(
        "--listen ADDRESS", "Listen on this address for other machines; 0.0.0.0 for all (default: loopback)."
    )
    no_page: bool = flag("--no-page", "Serve the gateway without the page.")
    no_open: bool = flag("--no-open", "Do not open a browser.")
    recordings: Path | None = option(
        "--recordings DIR",
        "Folder for recordings that the page makes (default: ~/.local/share/rostether/recordings).",
        type=click.Path(path_type=Path, file_okay=False),
    )
    tiles: Path | None = option(
        "--tiles FILE",
        "Map tiles for the map without internet, an .mbtiles file with pictures.",
        type=EXISTING_FILE,
    )
    panel: str | None = option(
        "--panel PANEL", f"Open a panel: {', '.join(PANELS)}.", type=click.Choice(PANELS)
    )
    shown: tuple[str, ...] = option(
        "--show NAME",
        "What the panel shows: /TOPIC/FIELD for plots, a topic for images, an .rviz file for scene.",
        multiple=True,
    )


@verb(
    "dashboard",
    """
    rostether dashboard                                   open the page in a browser
    rostether dashboard --port 8080 --no-open
    rostether dashboard --listen 0.0.0.0 --token 7f3c9a   for phones and other machines
    rostether dashboard --tiles campus.mbtiles            streets on the map
    rostether dashboard --panel plots --show /ultrasound/range
    rostether dashboard --ros2 zenoh
    """,
)
@option_group("options", DashboardOptions)
@click.argument("words", nargs=-1, metavar="[NAME:=OTHER]...")
@viewer_access_options
@graph_options(served=True)
@msg_path_option
def dashboard(
    options: DashboardOptions,
    words: tuple[str, ...],
    gateways: GatewayOptions,
    graph: GraphOptions,
    msg_paths: tuple[Path, ...],
) -> None:
    """Show the robot in a browser: boards, topics, plots, images, 3D, parameters.

    The page needs no internet and no installation on the device that shows it. It connects to the gateway on
    the same port, which Foxglove can use too. `rostether serve --dashboard` does the same and connects
    boards.

    The node's name is dashboard, or dashboard_PORT on another port; __name:=, __ns:= and from:=to work as for
    any ROS node.
    """
    address, node = read_gateway_arguments(words, graph.arguments)
    if address != DEFAULT_ADDRESS:
        raise click.UsageError(f"{address!r} is not NAME:=OTHER; --port and --listen choose where to listen")
    if options.shown and options.panel is None:
        raise click.UsageError("--show needs --panel")
    settings = DashboardSettings(
        address=_listen_address(options.listen, options.port),
        access=replace(gateways, allow=graph.allow),
        node=node,
        has_page=not options.no_page,
        recordings=options.recordings,
        tiles=options.tiles,
        views=(read_view(options.panel, options.shown),) if options.panel is not None else (),
        remote_option="`rostether dashboard --listen 0.0.0.0`",
    )

    @asynccontextmanager
    async def opened(graphs: ServedGraphs, report: Report) -> AsyncIterator[Dashboard]:
        async with served_dashboard(settings, graphs, msg_paths, report) as served:
            if settings.has_page and not options.no_open and has_browser(os.environ):
                await open_browser(served.view_urls[0] if served.view_urls else served.url)
            yield served

    serve_gateway(graph, msg_paths, opened)


def _listen_address(listen: str | None, port: int | None) -> str:
    host = listen or DEFAULT_ADDRESS
    host = f"[{host}]" if ":" in host and not host.startswith("[") else host
    return host if port is None else f"{host}:{port}"
