"""What commands are told about single boards: the file of settings, and which ports to probe."""

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
    help="Names and settings of boards (~/.config/rostether/devices.toml).",
)
discover_option = click.option(
    "--discover", is_flag=True, help="Look for boards on the serial ports too, as without an ADDRESS."
)
probe_option = click.option(
    "--probe",
    "probes",
    multiple=True,
    metavar="WHAT",
    help="Ask this port too whether a board is there: a USB id such as 1a86:7523, a path, a pattern, all.",
)


def read_devices(config: Path | None, probes: Sequence[str]) -> DeviceBook:
    """Read the file of settings, the user's own unless one is named. Raises ConfigError."""
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
    """Return a line for each board in the file that nothing can choose: it is easily a forgotten mark."""
    from rostether.ports.devices_toml import MATCH_KEYS

    return [
        f"the settings of devices.{name} are for no board: write what to recognise it by "
        f"({', '.join(MATCH_KEYS)}), or put ?name={name} behind an ADDRESS"
        for name in devices.unchosen([link.name for link in links])
    ]
