"""Shell completion of serial ports."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem


def complete_ports(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the serial ports that begin with the typed text; else let the shell complete files."""
    from rostether.transports.opening import list_serial_ports

    ports = [CompletionItem(port.path, help=port.description) for port in list_serial_ports()]
    found = [each for each in ports if each.value.startswith(incomplete)]
    # The shell does not know that `pty:` and `sim:` come before a path.
    return found or [CompletionItem(incomplete, type="file")]
