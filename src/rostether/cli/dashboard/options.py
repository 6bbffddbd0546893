"""The option `--dashboard` of other verbs."""

from __future__ import annotations

import click

from rostether.cli.gateway.options import DEFAULT_PLACE, is_place
from rostether.cli.shell.option_group import OptionalValueOption

dashboard_option = click.option(
    "--dashboard",
    cls=OptionalValueOption,
    alone=DEFAULT_PLACE,
    is_value=is_place,
    metavar="[HOST:PORT]",
    help="Serve the dashboard, a page for browsers (127.0.0.1:8765).",
)
