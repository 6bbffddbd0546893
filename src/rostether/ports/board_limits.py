"""The limits of boards that a user may set, for all boards by `--limit` or for one board in devices.toml."""

from __future__ import annotations

from typing import NamedTuple


class Limit(NamedTuple):
    """The name of the setting, and its allowed range."""

    setting: str
    lowest: float
    highest: float


_MIB = 1024 * 1024

# By the key in devices.toml; the settings are those of `bridge.settings.BridgeSettings`.
BOARD_LIMITS = {
    "frame_bytes": Limit("frame_bytes", 64, 65535),
    "endpoints": Limit("endpoints", 1, 4096),
    "messages_hz": Limit("messages_hz", 1, 10_000_000),
    "topic_bytes": Limit("queue_bytes", 8192, 256 * _MIB),
    "connection_bytes": Limit("unsent_bytes", 65536, 256 * _MIB),
    "subscriber_bytes": Limit("subscriber_bytes", 65536, 1024 * _MIB),
    "service_calls": Limit("queued_calls", 1, 4096),
    "service_s": Limit("service_timeout_s", 0.1, 3600),
    "parameter_s": Limit("parameter_timeout_s", 0.05, 60),
}


def may_be_broken(key: str) -> bool:
    """Return whether a limit is a time or a rate, which may have a fraction."""
    return key.endswith(("_s", "_hz"))
