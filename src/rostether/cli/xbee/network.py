"""xbee_network.py as a role: serves the boards of a radio network, with the same arguments."""

from __future__ import annotations

from collections.abc import Mapping

import click

from rostether.cli.bridge.serial_node import HostRole, run_host
from rostether.cli.role.node import RoleVerb, node_arguments
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError


@verb(
    "xbee-network",
    """
    rostether role xbee-network /dev/ttyUSB0 1 2 3
    rostether role xbee-network /dev/ttyUSB0 1 __name:=greenhouse
    """,
    cls=RoleVerb,
)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="PORT ID... [NAME:=VALUE]...")
async def xbee_network(arguments: tuple[str, ...]) -> None:
    """Bridge the boards whose XBee radios have the addresses ID, over the radio on PORT.

    Each board is a node: xbee_network, xbee_network_2 and so on.
    """
    host = HostRole("xbee_network", "RosSerial Xbee Network", (), network_link)
    await run_host(host, node_arguments(arguments))


def network_link(rest: list[str], parameters: Mapping[str, object], options: str) -> str:
    """Return the link address from the arguments. Raises ConfigError."""
    if len(rest) < 2:
        raise ConfigError(
            "give the port of the XBee radio and the address of each board, for example /dev/ttyUSB0 1 2"
        )
    port, *ids = rest
    return f"xbee:{port}?peers={','.join(ids)}&{options}"
