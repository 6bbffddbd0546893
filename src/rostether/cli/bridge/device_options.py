"""Options about single boards: the settings file and the ports to probe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.ports.device_book import DeviceBook
    from rostether.transports.address import Address

config_option = click.option(
    "--config",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="File of board names and settings (default: ~/.config/rostether/devices.toml).",
)
discover_option = click.option(
    "--discover", is_flag=True, help="Also search the serial ports for boards, as without an ADDRESS."
)
probe_option = click.option(
    "--probe",
    "probes",
    multiple=True,
    metavar="WHAT",
    help="Also probe this port for a board: a USB id such as 1a86:7523, a path, a pattern, or all.",
)


def read_devices(config: Path | None, probes: Sequence[str]) -> DeviceBook:
    """Read the settings file, by default the user's. Raises ConfigError."""
    from rostether.ports.config_paths import devices_toml_path
    from rostether.ports.device_book import DeviceBook
    from rostether.ports.devices_toml import read_devices_toml
    from rostether.ports.port_pattern import is_entry

    for probe in probes:
        if not is_entry(probe):
            raise ConfigError(
                f"--probe {probe}: write a USB id such as 1a86:7523, a path or pattern such as "
                "'/dev/ttyUSB*', or all"
            )
    path = config if config is not None else devices_toml_path()
    book = read_devices_toml(path, is_required=config is not None)
    if not probes:
        return book
    discovery = replace(book.discovery, probe=(*book.discovery.probe, *probes))
    return DeviceBook(book.devices, defaults=book.defaults, discovery=discovery)


def unchosen_lines(devices: DeviceBook, links: Sequence[Address]) -> list[str]:
    """Return a line for each board in the file that cannot match any port."""
    from rostether.ports.devices_toml import MATCH_KEYS

    return [
        f"devices.{name} matches no board: add a key to identify it ({', '.join(MATCH_KEYS)}), or append "
        f"?name={name} to an ADDRESS"
        for name in devices.unchosen([link.name for link in links])
    ]
