"""`rostether dashboard`: the robot in a browser."""

from __future__ import annotations

import asyncio
import os
import sys
import webbrowser
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import click

from rostether.cli.access.graph_options import (
    SERVED_ALLOW,
    SERVED_MASTER,
    GraphOptions,
    graph_options,
)
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.served_graphs import ServedGraphs
from rostether.cli.dashboard.served import Dashboard, DashboardSettings, served_dashboard
from rostether.cli.gateway.gateways import Tell
from rostether.cli.gateway.node import read_gateway_words
from rostether.cli.gateway.options import DEFAULT_PLACE, GatewayOptions, viewer_access_options
from rostether.cli.gateway.serving import serve_gateway
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.verbs import Verb


@dataclass(frozen=True, slots=True)
class DashboardOptions:
    """The options of `dashboard`."""

    port: int | None
    listen: str | None
    no_page: bool
    no_open: bool
    recordings: Path | None
    tiles: Path | None


_dashboard_options = option_group(
    "options",
    DashboardOptions,
    (
        click.option(
            "-p",
            "--port",
            type=click.IntRange(0, 65535),
            metavar="PORT",
            help="Port of the page (the next free one from 8765).",
        ),
        click.option(
            "--listen",
            metavar="ADDRESS",
            help="Listen at this address for other machines; 0.0.0.0 for all addresses (loopback).",
        ),
        click.option("--no-page", is_flag=True, help="Serve the gateway without the page."),
        click.option("--no-open", is_flag=True, help="Do not open a browser."),
        click.option(
            "--recordings",
            type=click.Path(path_type=Path, file_okay=False),
            metavar="DIR",
            help="Folder for recordings that the page makes (~/.local/share/rostether/recordings).",
        ),
        click.option(
            "--tiles",
            type=click.Path(path_type=Path, dir_okay=False, exists=True),
            metavar="FILE",
            help="Map tiles for the map without internet, an .mbtiles file with pictures.",
        ),
    ),
)


@click.command(
    cls=Verb,
    examples="""
    rostether dashboard                                   open the page in a browser
    rostether dashboard --port 8080 --no-open
    rostether dashboard --listen 0.0.0.0 --token 7f3c9a   for phones and other machines
    rostether dashboard --tiles campus.mbtiles            streets on the map
    rostether dashboard --ros2 zenoh
    """,
)
@_dashboard_options
@click.argument("words", nargs=-1, metavar="[NAME:=OTHER]...")
@viewer_access_options
@graph_options(master=SERVED_MASTER, allow=SERVED_ALLOW, serving=True)
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
    the same port, which Foxglove can use too. `rostether serve --dashboard` does the same beside boards.

    Its node is dashboard, on other ports dashboard_PORT; __name:=, __ns:= and from:=to work as for any ROS
    node.
    """
    place, node = read_gateway_words(words, graph.arguments)
    if place != DEFAULT_PLACE:
        raise click.UsageError(f"{place!r} is not NAME:=OTHER; --port and --listen choose where to listen")
    settings = DashboardSettings(
        place=_place(options.listen, options.port),
        access=replace(gateways, allow=graph.allow),
        node=node,
        has_page=not options.no_page,
        recordings=options.recordings,
        tiles=options.tiles,
        wider="`rostether dashboard --listen 0.0.0.0`",
    )

    @asynccontextmanager
    async def opened(graphs: ServedGraphs, tell: Tell) -> AsyncIterator[Dashboard]:
        async with served_dashboard(settings, graphs, msg_paths, tell) as served:
            if settings.has_page and not options.no_open and _has_browser(os.environ):
                await open_browser(served.url)
            yield served

    serve_gateway(graph, msg_paths, opened)


async def open_browser(url: str) -> None:
    """Show an address in the user's browser; without one nothing happens."""
    # A browser that does not start is no error: the address is on the screen.
    await asyncio.gather(asyncio.to_thread(webbrowser.open, url), return_exceptions=True)


def _has_browser(environ: Mapping[str, str]) -> bool:
    """Return whether a window can open: a text browser in this terminal would hide the output."""
    if not sys.stdout.isatty():
        return False
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in environ
    return bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))


def _place(listen: str | None, port: int | None) -> str:
    host = listen or DEFAULT_PLACE
    host = f"[{host}]" if ":" in host and not host.startswith("[") else host
    return host if port is None else f"{host}:{port}"
