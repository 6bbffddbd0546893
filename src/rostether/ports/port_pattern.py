"""How users specify ports: a USB id, a path or link, a pattern, or `all`."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from fnmatch import fnmatchcase
from glob import glob, has_magic
from pathlib import Path

from rostether.ports.board_identity import BoardIdentity

ALL = "all"
_USB_ID = re.compile(r"[0-9a-f]{4}:[0-9a-f]{4}")
_WINDOWS_PORT = re.compile(r"COM[0-9*?]+", re.IGNORECASE)


def is_usb_id(text: str) -> bool:
    """Return whether a text is a vendor and product id as in `rostether ports`."""
    return _USB_ID.fullmatch(text.lower()) is not None


def is_port_pattern(text: str) -> bool:
    """Return whether a text is a port's path or pattern."""
    return "/" in text or _WINDOWS_PORT.fullmatch(text) is not None


def is_entry(text: str) -> bool:
    """Return whether a text is a valid entry for `fits_entry`."""
    return text == ALL or is_usb_id(text) or is_port_pattern(text)


def fits_port(port: str, pattern: str) -> bool:
    """Return whether a port matches a path, a link to it, or a pattern of either."""
    if fnmatchcase(port, pattern):
        return True
    real_port = os.path.realpath(port)
    return any(os.path.realpath(path) == real_port for path in _expand(pattern))


def fits_entry(identity: BoardIdentity, entry: str) -> bool:
    """Return whether a port matches an entry: `all`, a USB id, a path or a pattern."""
    if entry == ALL:
        return True
    if is_usb_id(entry):
        return identity.usb_id == entry.lower()
    return identity.port is not None and fits_port(identity.port, entry)


def named_ports(entries: Iterable[str]) -> list[str]:
    """Return the existing paths that entries name; the system's list of ports may lack them."""
    found: list[str] = []
    for entry in entries:
        if is_port_pattern(entry) and "/" in entry:
            found += [path for path in _expand(entry) if Path(path).exists()]
    return found


def _expand(pattern: str) -> list[str]:
    # Path.glob does not accept absolute patterns.
    return glob(pattern) if has_magic(pattern) else [pattern]  # noqa: PTH207
