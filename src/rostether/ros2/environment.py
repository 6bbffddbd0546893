"""The ROS 2 environment variables, read as the middlewares read them.

Sources: the ROS 2 documentation of ROS_DOMAIN_ID and of the discovery range, and rmw_zenoh's documentation of
its ZENOH_* variables.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from msgspec import Struct

from rostether.errors import ConfigError

# The highest domain with DDS ports below 65536; all middlewares have this limit.
MAX_DOMAIN_ID = 232

_DISCOVERY_RANGES = ("", "SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT")


class Ros2Environment(Struct, frozen=True):
    """The settings of a ROS 2 graph. Empty strings and None mean "not set": the middleware's default applies.

    `zenoh_overrides` are pairs of a zenoh configuration path and its value in JSON5.
    """

    domain_id: int = 0
    middleware: str = ""
    zenoh_session_config: Path | None = None
    zenoh_router_config: Path | None = None
    zenoh_overrides: tuple[tuple[str, str], ...] = ()

    @classmethod
    def read(cls, environ: Mapping[str, str] | None = None) -> Ros2Environment:
        """Read the variables, those of os.environ by default. Raises ConfigError."""
        values = os.environ if environ is None else environ
        _check_discovery_range(values.get("ROS_AUTOMATIC_DISCOVERY_RANGE", ""))
        return cls(
            domain_id=_domain_id(values.get("ROS_DOMAIN_ID", "")),
            middleware=values.get("RMW_IMPLEMENTATION", "").strip(),
            zenoh_session_config=_config_file(values, "ZENOH_SESSION_CONFIG_URI"),
            zenoh_router_config=_config_file(values, "ZENOH_ROUTER_CONFIG_URI"),
            zenoh_overrides=_overrides(values.get("ZENOH_CONFIG_OVERRIDE", "")),
        )


def _domain_id(text: str) -> int:
    if not text.strip():
        return 0
    if text.strip().isdecimal() and len(text) <= 20 and int(text) <= MAX_DOMAIN_ID:
        return int(text)
    raise ConfigError(f"ROS_DOMAIN_ID={text!r:.80} is not a domain; give a number from 0 to {MAX_DOMAIN_ID}")


def _check_discovery_range(text: str) -> None:
    if text.strip().upper() not in _DISCOVERY_RANGES:
        raise ConfigError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE={text!r:.80} is unknown; give SUBNET, LOCALHOST, OFF or "
            "SYSTEM_DEFAULT"
        )


def _config_file(values: Mapping[str, str], variable: str) -> Path | None:
    text = values.get(variable, "").strip()
    if not text:
        return None
    path = Path(text.removeprefix("file://"))
    if not path.is_file():
        raise ConfigError(f"{variable}={text!r:.200} is not a file; give the path of a zenoh configuration")
    return path


def _overrides(text: str) -> tuple[tuple[str, str], ...]:
    pairs = []
    for part in text.split(";"):
        if not part.strip():
            continue
        path, equals, value = (piece.strip() for piece in part.partition("="))
        if not (path and equals and value):
            raise ConfigError(
                f"ZENOH_CONFIG_OVERRIDE contains {part!r:.80}, which is not path=value; "
                'write it as listen/endpoints=["tcp/127.0.0.1:0"], with ";" between entries'
            )
        pairs.append((path, value))
    return tuple(pairs)
