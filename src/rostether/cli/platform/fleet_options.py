"""The options that select a fleet's network and its robots, as one value."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import click

from rostether.cli.shell.option_group import PORT, option, option_group
from rostether.errors import ConfigError
from rostether.platform.command_frame import ALL_GROUPS, NO_KEY
from rostether.platform.command_link import SenderSettings
from rostether.platform.fleet import FLEET_GROUP, FLEET_PORT, FleetSettings
from rostether.platform.fleet_key import read_fleet_key
from rostether.platform.multicast_socket import GroupAddress

# A robot's id has 32 bits in a frame, and each group is one of 32 bits.
MAX_ROBOT = 0xFFFF_FFFF
_GROUPS = 32


def group_mask(words: Iterable[str], label: str) -> int:
    """Return the mask of groups, given their numbers. Raises ConfigError, whose text begins with `label`."""
    mask = 0
    for word in words:
        if not word.isdecimal() or int(word) >= _GROUPS:
            raise ConfigError(f"{label} are numbers from 0 to {_GROUPS - 1}, not {word!r:.200}")
        mask |= 1 << int(word)
    return mask


@dataclass(frozen=True, slots=True)
class FleetOptions:
    """The options that select a fleet's network and its robots."""

    groups: str | None = option("--groups N,N", "Only robots of these groups, numbers from 0 to 31.")
    key_file: str | None = option("--key-file FILE", "The fleet's key, 32 hexadecimal digits.")
    group_address: str = option(
        "--group-address ADDRESS",
        "The multicast group, IPv4 or IPv6.",
        default=FLEET_GROUP,
        show_default=True,
    )
    port: int = option("--port", "The group's port.", type=PORT, default=FLEET_PORT, show_default=True)
    interfaces: tuple[str, ...] = option(
        "--interface NAME", "Send on this network interface, e.g. wlan0; may be repeated.", multiple=True
    )
    ttl: int = option(
        "--ttl",
        "The time to live of datagrams: how many networks they cross.",
        type=click.IntRange(0, 255),
        default=1,
        show_default=True,
    )
    unicast: tuple[str, ...] = option(
        "--unicast ADDRESS",
        "Send to this robot's address too, where multicast does not arrive; may be repeated.",
        multiple=True,
    )

    def settings(self, robot: int | None = None) -> FleetSettings:
        """Return the settings, for one robot unless it is None.

        Raises ConfigError, and UsageError for a robot and groups.
        """
        mask = ALL_GROUPS if self.groups is None else group_mask(self.groups.split(","), "--groups")
        if robot is not None and mask != ALL_GROUPS:
            raise click.UsageError("give ROBOT or --groups, not both")
        return FleetSettings(
            SenderSettings(
                mask if robot is None else robot,
                to_groups=robot is None,
                key=read_fleet_key(self.key_file) if self.key_file else NO_KEY,
            ),
            GroupAddress(self.group_address, self.port, self.interfaces, self.ttl),
            self.unicast,
        )


# Adds the options of a fleet; the verb gets them as `fleet`.
fleet_options = option_group("fleet", FleetOptions)
