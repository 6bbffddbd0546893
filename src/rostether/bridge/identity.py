"""The node name of a board: from its link address, else from devices.toml, else from a stable identity.

The identity of a serial port on USB is the adapter's serial number, if it has one: a board keeps its name
whichever port it gets. That of another port is its path. That of a board on a network is its address without
the port, which changes with every connection. If two boards would have the same name, `_2`, `_3` ... is
appended.
"""

from __future__ import annotations

import re

from rostether.names.graph_name import join as join_names
from rostether.ports.board_identity import BoardIdentity
from rostether.ports.settings import NO_SETTINGS, DeviceSettings
from rostether.transports.address import Address, PtyAddress, SerialAddress, UdpAddress
from rostether.transports.board_keys import NO_PROOF, Proof

_ILLEGAL = re.compile(r"[^A-Za-z0-9_]+")
# Readable in every tool; a longer name that a peer chose is cut.
MAX_NAME_CHARACTERS = 64


def node_name(
    address: Address, peer: str, identity: BoardIdentity, device: DeviceSettings = NO_SETTINGS
) -> str:
    """Return the full node name of a link's board."""
    namespace = join_names("/", address.ns or device.namespace or "/")
    return join_names(namespace, node_base_name(address, peer, identity, device))


def node_base_name(
    address: Address, peer: str, identity: BoardIdentity, device: DeviceSettings = NO_SETTINGS
) -> str:
    """Return a legal name without slashes (`name=` may have some) for a link's board.

    `peer` is the `peer` of its transport.
    """
    given = address.name if address.name is not None else device.name
    if given is not None:
        return given.strip("~/")
    if identity.own_serial_number is not None:
        return legal_base_name(f"board_{identity.own_serial_number}")
    if isinstance(address, SerialAddress):
        return legal_base_name(re.split(r"[/\\]", address.path)[-1])
    if isinstance(address, PtyAddress):
        return legal_base_name(address.link.rsplit("/", 1)[-1])
    return legal_base_name(peer if identity.address is None else f"{_protocol(address)}_{identity.address}")


def identify_peer(remote: str | None, proof: Proof = NO_PROOF) -> BoardIdentity:
    """Return the identity of a board that is not on a serial port; `remote` is its transport's `remote`."""
    return BoardIdentity(address=remote, psk=proof.psk, certificate=proof.certificate)


def hardware_id(address: Address, peer: str, identity: BoardIdentity) -> str:
    """Return a text that stays the same when the board reconnects; `peer` as in `node_base_name`."""
    if identity.address is not None:
        return f"{_protocol(address)} {identity.address}"
    return identity.own_serial_number or identity.usb_location or peer


def _protocol(address: Address) -> str:
    return "udp" if isinstance(address, UdpAddress) else "tcp"


def numbered(base_name: str, number: int) -> str:
    """Return the name of the `number`th board of one name, counted from 1."""
    return base_name if number == 1 else f"{base_name}_{number}"


def legal_base_name(text: str) -> str:
    """Return a legal node name without slashes that resembles a text."""
    name = _ILLEGAL.sub("_", text).strip("_")[:MAX_NAME_CHARACTERS]
    return name if name[:1].isalpha() else f"board_{name}".rstrip("_")
