"""`--limit NAME=VALUE`: the limits of the bridge, checked when they are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import click

from rostether.errors import ConfigError

if TYPE_CHECKING:
    from rostether.bridge.settings import BridgeSettings


class Limit(NamedTuple):
    """One limit: the setting it is, and what it may be."""

    setting: str
    lowest: float
    highest: float


_MIB = 1024 * 1024

LIMITS = {
    "frame-bytes": Limit("frame_bytes", 64, 65535),
    "endpoints": Limit("endpoints", 1, 4096),
    "connections": Limit("connections", 1, 4096),
    "connections-per-host": Limit("connections_per_host", 1, 4096),
    "topic-bytes": Limit("queue_bytes", 8192, 256 * _MIB),
    "connection-bytes": Limit("unsent_bytes", 65536, 256 * _MIB),
    "subscriber-bytes": Limit("subscriber_bytes", 65536, 1024 * _MIB),
    "service-calls": Limit("queued_calls", 1, 4096),
    "service-s": Limit("service_timeout_s", 0.1, 3600),
    "parameter-s": Limit("parameter_timeout_s", 0.05, 60),
    "grace-s": Limit("grace_s", 0, 86400),
}
"""By the name that a user writes."""

limit_option = click.option(
    "--limit",
    "limits",
    multiple=True,
    metavar="NAME=VALUE",
    help=f"Set a limit; may be repeated. Names: {', '.join(LIMITS)}.",
)


def read_limits(texts: Sequence[str]) -> BridgeSettings:
    """Return the settings with these limits. Raises ConfigError."""
    from rostether.bridge.settings import DEFAULT_SETTINGS

    given: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        limit = LIMITS.get(name)
        if limit is None or not equals:
            raise ConfigError(f"--limit {text}: write NAME=VALUE, where NAME is one of {', '.join(LIMITS)}")
        is_time = name.endswith("-s")
        try:
            number = float(value) if is_time else int(value)
        except ValueError:
            number = float("nan")
        if not limit.lowest <= number <= limit.highest:
            kind = "a number of seconds" if is_time else "a whole number"
            raise ConfigError(
                f"--limit {text}: {kind} from {limit.lowest:g} to {limit.highest:.10g} is needed"
            )
        given[limit.setting] = number
    return replace(DEFAULT_SETTINGS, **given)  # type: ignore[arg-type]
