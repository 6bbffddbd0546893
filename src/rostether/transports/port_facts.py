"""The facts about a serial port that are known without opening it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

from msgspec import Struct

from rostether.transports.port_holders import Holder, find_holders, is_character_device
from rostether.transports.serial_port import ListPorts

# The number of ports that fits on a line.
LISTED_PORTS = 6

# Debian's, Ubuntu's and Fedora's; Arch has uucp.
USUAL_GROUP = "dialout"

_GROUP_MAY_USE = 0o060
_MAINBOARD_PREFIX = "ttyS"
_LIKELY_PREFIXES = ("ttyACM", "ttyUSB", "cu.usb")


class PortFacts(Struct, frozen=True):
    """The state of one port; `group` may use it, None if membership would not help.

    For a port that does not exist, `near` are the ports with a similar name, and `others` the first ports of
    this machine, as text for users.
    """

    path: str
    exists: bool = True
    is_device: bool = True
    may_open: bool = True
    group: str | None = None
    holders: tuple[Holder, ...] = ()
    near: tuple[str, ...] = ()
    others: tuple[str, ...] = ()


def read_port_facts(path: str, list_ports: ListPorts) -> PortFacts:
    """Return the facts about a port. Takes a few ms, because it reads /proc."""
    # Windows has no files for its ports.
    has_files = os.name != "nt"
    if has_files and os.path.exists(path):  # noqa: PTH110 - follows links as opening does
        return PortFacts(
            path,
            is_device=is_character_device(path),
            may_open=may_open(path),
            group=group_of(path),
            holders=tuple(find_holders(path)),
        )
    shown = {port.path: f"{port.path} ({port.description})" for port in list_ports()}
    exists = not has_files and path.upper().removeprefix("\\\\.\\") in map(str.upper, shown)
    near = near_names(path, list(shown)) if has_files else get_close_matches(path, shown, n=3)
    return PortFacts(
        path,
        exists=exists,
        near=tuple(shown.get(each, each) for each in near),
        others=tuple(shown.values())[:LISTED_PORTS],
    )


def may_open(path: str) -> bool:
    """Return whether this user may open a port."""
    # Windows has no files for its ports.
    return os.name == "nt" or os.access(path, os.R_OK | os.W_OK)


def near_names(path: str, ports: Sequence[str]) -> list[str]:
    """Return the ports, and links in the same folder, with a similar name."""
    folder, name = Path(path).parent, Path(path).name
    try:
        beside = [str(folder / each) for each in sorted(os.listdir(folder))]  # noqa: PTH208 - only names
    except OSError:
        beside = []
    likely = [
        each
        for each in beside
        if each in ports or Path(each).name.startswith(_LIKELY_PREFIXES) or not str(folder).startswith("/dev")
    ]
    known = {Path(each).name: each for each in (*likely, *ports)}
    # A board on USB is not at a port of the mainboard.
    if not name.startswith(_MAINBOARD_PREFIX):
        known = {short: each for short, each in known.items() if not short.startswith(_MAINBOARD_PREFIX)}
    return [known[each] for each in get_close_matches(name, known, n=3, cutoff=0.6)]


def group_of(path: str) -> str | None:
    """Return the group whose members may use a port, the usual one if it is unknown; None: only root."""
    try:
        import grp

        status = Path(path).stat()
        group = grp.getgrgid(status.st_gid).gr_name
    except (ImportError, OSError, KeyError):
        return USUAL_GROUP
    if group == "root" or status.st_mode & _GROUP_MAY_USE != _GROUP_MAY_USE:
        return None
    return group
