"""The link that gives a pseudo-terminal a lasting name."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from rostether.errors import TransportOpenError
from rostether.transports.serial_errors import is_pseudo_terminal


def check_link(link: Path) -> None:
    """Raise TransportOpenError if the link would replace a file of the user."""
    if link.is_symlink():
        if link.exists() and not is_pseudo_terminal(str(link)):
            raise TransportOpenError(f"{link} is a link to something else; choose another path for pty:")
    elif link.exists():
        raise TransportOpenError(f"{link} already exists; remove it, or choose another path for pty:")


def place_link(link: Path, terminal: str) -> None:
    """Create the link atomically, so that a program that waits for the path never finds a wrong one."""
    fresh = link.with_name(f".{link.name}.{os.getpid()}")
    fresh.unlink(missing_ok=True)
    fresh.symlink_to(terminal)
    try:
        fresh.replace(link)
    except OSError:
        fresh.unlink(missing_ok=True)
        raise


def remove_link(link: Path, terminal: str) -> None:
    """Remove the link unless it now points to another terminal."""
    with contextlib.suppress(OSError):
        if str(link.readlink()) == terminal:
            link.unlink()
