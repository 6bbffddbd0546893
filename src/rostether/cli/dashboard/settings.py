"""Where and how a command serves the dashboard."""

from __future__ import annotations

from pathlib import Path

from msgspec import Struct, field

from rostether.cli.dashboard.view import View
from rostether.cli.gateway.gateways import NodeNaming
from rostether.cli.gateway.options import DEFAULT_ADDRESS, GatewayOptions
from rostether.transports.web_boards import WebBoards


class DashboardSettings(Struct, frozen=True):
    """Where the dashboard is served, and who may use it.

    `address` is [HOST:]PORT; without a port, the next free one from 8765 is used. Without `has_page` only the
    gateway is served. `views` are panels whose addresses are printed too. `remote_option` is the option or
    command that admits other machines; `{port}` in it becomes the port. `boards` are serial ports of the
    devices that show the page.
    """

    address: str = DEFAULT_ADDRESS
    access: GatewayOptions = field(default_factory=GatewayOptions)
    node: NodeNaming = field(default_factory=NodeNaming)
    has_page: bool = True
    recordings: Path | None = None
    tiles: Path | None = None
    views: tuple[View, ...] = ()
    remote_option: str = "--dashboard 0.0.0.0:{port}"
    boards: WebBoards | None = None
