"""The node name of a board: what its link address says, else what stays the same when it comes back.

A serial port on USB is named by the adapter's serial number where it has one, so that a board keeps its name
whichever port it gets; other ports by their path; boards on a network by their address without the port,
which changes with every connection. Two boards that would have one name are told apart by `_2`, `_3` ...
"""

from __future__ import annotations

import re

from rostether.transports.address import Address, PtyAddress, SerialAddress

_ILLEGAL = re.compile(r"[^A-Za-z0-9_]+")
# What people type stays readable in every tool; a peer's text is never longer.
MAX_NAME_CHARACTERS = 64


def node_base_name(address: Address, peer: str, serial_number: str | None = None) -> str:
    """Return a legal name without slashes (`name=` may have some) for who is at the other end of a link.

    `peer` is the transport's, `serial_number` the USB adapter's where there is one.
    """
    if address.name is not None:
        return address.name.strip("~/")
    if serial_number:
        return _legal(f"board_{serial_number}")
    if isinstance(address, SerialAddress):
        return _legal(re.split(r"[/\\]", address.path)[-1])
    if isinstance(address, PtyAddress):
        return _legal(address.link.rsplit("/", 1)[-1])
    kind, _, place = peer.partition(" ")
    if kind in ("tcp", "udp"):
        place = place.rpartition(":")[0].strip("[]") or place
    return _legal(f"{kind}_{place}")


def numbered(base_name: str, number: int) -> str:
    """Return the name of the `number`th board of one name, counted from 1."""
    return base_name if number == 1 else f"{base_name}_{number}"


def _legal(text: str) -> str:
    name = _ILLEGAL.sub("_", text).strip("_")[:MAX_NAME_CHARACTERS]
    return name if name[:1].isalpha() else f"board_{name}".rstrip("_")
