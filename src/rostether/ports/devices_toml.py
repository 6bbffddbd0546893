"""Reads devices.toml; errors about unknown or invalid keys contain the file and the key."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.mechanisms.toml_text import parse_toml, read_toml_text
from rostether.ports.device_book import DeviceBook
from rostether.ports.port_pattern import is_entry, is_port_pattern, is_usb_id
from rostether.ports.settings import (
    ANY_ACCESS,
    ANY_NAME,
    NO_SETTINGS,
    Access,
    DeviceMatch,
    DeviceSettings,
    DiscoverySettings,
    NameRule,
)
from rostether.ports.toml_table import TomlTable
from rostether.transports.address_parser import MAX_BAUD

# Queues are also bounded in bytes; this limit catches typing errors.
MAX_QUEUE_DEPTH = 100_000
# A day: the node of a board that is lost for longer is no longer useful.
MAX_GRACE_S = 86_400.0

DISCOVERY_KEYS = DiscoverySettings.__struct_fields__
MATCH_KEYS = DeviceMatch.__struct_fields__
SETTING_KEYS = tuple(key for key in DeviceSettings.__struct_fields__ if key not in ("name", "match"))
ACCESS_KEYS = Access.__struct_fields__


def read_devices_toml(path: Path, *, is_required: bool = False) -> DeviceBook:
    """Read a file; a missing file counts as empty unless `is_required`. Raises ConfigError."""
    try:
        return parse_devices_toml(read_toml_text(path), file=str(path))
    except ConfigError as error:
        if not isinstance(error.__cause__, FileNotFoundError):
            raise
        if is_required:
            raise ConfigError(f"{path}: no such file; create it, or omit --config") from None
    return DeviceBook()


def parse_devices_toml(text: str, *, file: str = "devices.toml") -> DeviceBook:
    """Parse a text; `file` is its name in errors. Raises ConfigError with file and key."""
    root = TomlTable(file, "", parse_toml(text, file), known=("discovery", "defaults", "devices"))
    discovery = _discovery(root.table("discovery", known=DISCOVERY_KEYS))
    defaults = _settings(root.table("defaults", known=SETTING_KEYS), NO_SETTINGS)
    devices = []
    marks: dict[DeviceMatch, str] = {}
    for name, table in root.tables("devices", known=(*MATCH_KEYS, *SETTING_KEYS)):
        table.check_name(name)
        match = _match(table)
        if match is not None:
            if match in marks:
                raise table.error(f"has the same keys as devices.{marks[match]}; keep one of them")
            marks[match] = name
        devices.append(replace(_settings(table, defaults), name=name, match=match))
    return DeviceBook(devices, defaults=defaults, discovery=discovery)


def _discovery(table: TomlTable) -> DiscoverySettings:
    hint = 'a USB id such as "1a86:7523", a path or pattern such as "/dev/ttyUSB*", or "all"'
    return DiscoverySettings(
        probe=tuple(table.texts("probe", is_entry, hint)), ignore=tuple(table.texts("ignore", is_entry, hint))
    )


def _match(table: TomlTable) -> DeviceMatch | None:
    """Return the match keys of a table, None if it has none: then only a link with its name selects it."""
    usb_id = table.text("usb_id", is_usb_id, 'two groups of four hex digits, such as "2341:0043"')
    address = table.text("address", _canonical, 'a numeric address, such as "192.168.1.20"')
    match = DeviceMatch(
        serial_number=table.text("serial_number"),
        usb_id=usb_id.lower() if usb_id is not None else None,
        usb_location=table.text("usb_location"),
        port=table.text("port", is_port_pattern, 'a path or pattern, such as "/dev/ttyUSB*"'),
        address=_canonical(address) if address is not None else None,
        psk=table.text("psk", bool, "the file of its key"),
        certificate=table.text("certificate", bool, "the file of its certificate"),
    )
    return None if match == DeviceMatch() else match


def _settings(table: TomlTable, base: DeviceSettings) -> DeviceSettings:
    return DeviceSettings(
        baud=_or(table.whole("baud", 1, MAX_BAUD), base.baud),
        reset=_or(table.flag("reset"), base.reset),
        namespace=_or(table.graph_name("namespace"), base.namespace),
        remap={**base.remap, **table.names_to_names("remap")},
        required_topics=_or(table.graph_names("required_topics"), base.required_topics),
        access=_access(table.table("access", known=ACCESS_KEYS), base.access),
        queue_depths={**base.queue_depths, **table.names_to_numbers("queue_depths", 1, MAX_QUEUE_DEPTH)},
        grace_s=_or(table.number("grace_s", 0.0, MAX_GRACE_S), base.grace_s),
        limits={**base.limits, **_limits(table.table("limits", known=tuple(BOARD_LIMITS)))},
    )


def _limits(table: TomlTable) -> dict[str, float]:
    given: dict[str, float] = {}
    for key, limit in BOARD_LIMITS.items():
        value = (
            table.number(key, limit.lowest, limit.highest)
            if may_be_fractional(key)
            else table.whole(key, int(limit.lowest), int(limit.highest))
        )
        if value is not None:
            given[limit.setting] = value
    return given


def _access(table: TomlTable, base: Access) -> Access:
    given: dict[str, NameRule] = {}
    for kind in ACCESS_KEYS:
        rule = table.table(kind, known=("allow", "deny"))
        if rule.is_given:
            allow = rule.name_patterns("allow")
            given[kind] = NameRule(allow, rule.name_patterns("deny") or ())
    rules = {kind: given.get(kind, getattr(base, kind)) for kind in ACCESS_KEYS}
    return ANY_ACCESS if all(rule == ANY_NAME for rule in rules.values()) else Access(**rules)


def _or(value: Any, base: Any) -> Any:
    return base if value is None else value


def _canonical(address: str) -> str | None:
    """Return a numeric address in its usual form, None for another text."""
    from ipaddress import ip_address  # imported only if a network board is configured

    try:
        return str(ip_address(address))
    except ValueError:
        return None


class Limit(NamedTuple):
    """The name of the setting, and its allowed range."""

    setting: str
    lowest: float
    highest: float


# By the key in devices.toml; the settings are those of `bridge.settings.BridgeSettings`.
BOARD_LIMITS = {
    "frame_bytes": Limit("frame_bytes", 64, 65535),
    "endpoints": Limit("endpoints", 1, 4096),
    "messages_hz": Limit("messages_hz", 1, 10_000_000),
    "topic_bytes": Limit("queue_bytes", 8192, 256 << 20),
    "connection_bytes": Limit("unsent_bytes", 65536, 256 << 20),
    "subscriber_bytes": Limit("subscriber_bytes", 65536, 1024 << 20),
    "service_calls": Limit("queued_calls", 1, 4096),
    "service_s": Limit("service_timeout_s", 0.1, 3600),
    "parameter_s": Limit("parameter_timeout_s", 0.05, 60),
}


def may_be_fractional(key: str) -> bool:
    """Return whether a limit is a time or a rate, which may have a fraction."""
    return key.endswith(("_s", "_hz"))
