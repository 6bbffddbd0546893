"""The options that select a fleet's network and its robots, as one value."""

from __future__ import annotations

from collections.abc import Iterable

import click
from msgspec.structs import replace

from rostether.cli.shell.option_group import PORT, add_option, option_group
from rostether.errors import ConfigError
from rostether.platform.command_frame import ALL_GROUPS, NO_KEY
from rostether.platform.command_link import SenderSettings
from rostether.platform.fleet import FLEET_GROUP, FLEET_PORT, FleetSettings
from rostether.platform.fleet_key import read_fleet_key
from rostether.platform.multicast_socket import GroupAddress

# A robot's id has 32 bits in a frame, and each group is one of 32 bits.
MAX_ROBOT = 0xFFFF_FFFF
_GROUPS = 32

_OPTIONS = (
    add_option("--groups N,N", "Only robots of these groups, numbers from 0 to 31."),
    add_option("--key-file FILE", "The fleet's key, 32 hexadecimal digits."),
    add_option(
        "--group-address ADDRESS",
        "The multicast group, IPv4 or IPv6.",
        default=FLEET_GROUP,
        show_default=True,
    ),
    add_option("--port", "The group's port.", type=PORT, default=FLEET_PORT, show_default=True),
    add_option(
        "--interface interfaces NAME",
        "Send on this network interface, e.g. wlan0; may be repeated.",
        multiple=True,
    ),
    add_option(
        "--ttl",
        "The time to live of datagrams: how many networks they cross.",
        type=click.IntRange(0, 255),
        default=1,
        show_default=True,
    ),
    add_option(
        "--unicast ADDRESS",
        "Send to this robot's address too, where multicast does not arrive; may be repeated.",
        multiple=True,
    ),
)


def group_mask(words: Iterable[str], label: str) -> int:
    """Return the mask of groups, given their numbers. Raises ConfigError, whose text begins with `label`."""
    mask = 0
    for word in words:
        if not word.isdecimal() or int(word) >= _GROUPS:
            raise ConfigError(f"{label} are numbers from 0 to {_GROUPS - 1}, not {word!r:.200}")
        mask |= 1 << int(word)
    return mask


def for_robot(fleet: FleetSettings, robot: int | None) -> FleetSettings:
    """Return the settings for one robot, unchanged for None. Raises UsageError for a robot and groups."""
    if robot is None:
        return fleet
    if fleet.sender.target != ALL_GROUPS:
        raise click.UsageError("give ROBOT or --groups, not both")
    return replace(fleet, sender=replace(fleet.sender, target=robot, to_groups=False))


def fleet_settings(
    *,
    groups: str | None = None,
    key_file: str | None = None,
    group_address: str = FLEET_GROUP,
    port: int = FLEET_PORT,
    interfaces: tuple[str, ...] = (),
    ttl: int = 1,
    unicast: tuple[str, ...] = (),
) -> FleetSettings:
    """Return the settings of the options. Raises ConfigError."""
    mask = ALL_GROUPS if groups is None else group_mask(groups.split(","), "--groups")
    return FleetSettings(
        SenderSettings(mask, key=read_fleet_key(key_file) if key_file else NO_KEY),
        GroupAddress(group_address, port, interfaces, ttl),
        unicast,
    )


# Adds the options of a fleet; the verb gets a FleetSettings, without a robot's id, as `fleet`.
fleet_options = option_group("fleet", fleet_settings, _OPTIONS)
