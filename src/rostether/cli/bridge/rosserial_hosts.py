"""The nodes of rosserial_server and rosserial_xbee as roles, with their names and parameters.

serial_node             ~port /dev/ttyACM0, ~baud 57600
socket_node             ~port 11411, ~listen
udp_socket_node         ~server_port 11411, ~listen; the boards' addresses are learned, not set by ~client_*
xbee_network.py         PORT ID...
message_info_service    no parameters; for other programs, as rostether's bridge does not need it

~listen is an addition: the address to listen on, for boards on the network.
"""

from __future__ import annotations

from collections.abc import Mapping

import click

from rostether.cli.bridge.serial_node import HostRole, read_whole_number, run_host
from rostether.cli.role.node import RoleVerb, node_arguments, node_words, role
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.names.remap import Arguments
from rostether.transports.address import DEFAULT_PORT

# As in rosserial_server.
_DEFAULT_SERIAL_PORT = "/dev/ttyACM0"


@verb(
    "rosserial-server-serial",
    "rostether role rosserial-server-serial _port:=/dev/ttyACM0 _baud:=115200",
    cls=RoleVerb,
)
@node_words
async def serial(arguments: tuple[str, ...]) -> None:
    """Bridge the board at ~port with ~baud."""
    host = HostRole("rosserial_server_serial_node", "rosserial server", ("port", "baud"), _serial_link)
    await run_host(host, node_arguments(arguments))


@verb("rosserial-server-socket", "rostether role rosserial-server-socket _port:=11411", cls=RoleVerb)
@node_words
async def socket(arguments: tuple[str, ...]) -> None:
    """Bridge the boards that connect to the TCP port ~port."""
    host = HostRole("rosserial_server_socket_node", "rosserial server", ("port", "listen"), _socket_link)
    await run_host(host, node_arguments(arguments))


@verb("rosserial-server-udp", "rostether role rosserial-server-udp _server_port:=11411", cls=RoleVerb)
@node_words
async def udp(arguments: tuple[str, ...]) -> None:
    """Bridge the boards that send to the UDP port ~server_port."""
    known = ("server_port", "client_port", "client_addr", "listen")
    host = HostRole("rosserial_server_udp_socket_node", "rosserial server", known, _udp_link)
    await run_host(host, node_arguments(arguments))


@role("message-info-service", "rostether role message-info-service")
async def message_info(graph: TypedGraph, _: Arguments) -> None:
    """Offer the md5sum and the text of definitions: services message_info and service_info."""
    from rostether.msgdef.registry import Registry
    from rostether.nodes.message_info import serve_message_info

    await serve_message_info(graph, Registry.from_environment())


def _serial_link(rest: list[str], parameters: Mapping[str, object], options: str) -> str:
    baud = parameters.get("baud")
    speed = "" if baud is None else f"&baud={read_whole_number(baud, 'baud')}"
    return f"{parameters.get('port', _DEFAULT_SERIAL_PORT)}?{options}{speed}"


def _socket_link(rest: list[str], parameters: Mapping[str, object], options: str) -> str:
    port = read_whole_number(parameters.get("port", DEFAULT_PORT), "port")
    return f"tcp://{parameters.get('listen', '')}:{port}?{options}"


def _udp_link(rest: list[str], parameters: Mapping[str, object], options: str) -> str:
    port = read_whole_number(parameters.get("server_port", DEFAULT_PORT), "server_port")
    return f"udp://{parameters.get('listen', '')}:{port}?{options}"


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
