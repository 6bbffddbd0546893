"""Options of bridges: the settings file, the ports to probe, and limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rostether.cli.shell.option_group import PATH, Function, add_flag, add_option
from rostether.errors import ConfigError
from rostether.ports.devices_toml import BOARD_LIMITS, Limit, may_be_fractional
from rostether.ros1.graph_limits import DEFAULT_GRAPH_LIMITS, GraphLimits

if TYPE_CHECKING:
    from rostether.bridge.settings import BridgeSettings
    from rostether.ports.device_book import DeviceBook
    from rostether.transports.address import Address

config_option = add_option(
    "--config FILE",
    "File of board names and settings (default: ~/.config/rostether/devices.toml).",
    type=PATH,
)
discover_option = add_flag("--discover", "Also search the serial ports for boards, as without an ADDRESS.")
probe_option = add_option(
    "--probe probes WHAT",
    "Also probe this port for a board: a USB id such as 1a86:7523, a path, a pattern, or all.",
    multiple=True,
)

# The limits of `bridge.settings.BridgeSettings`, by their names on the command line, and the allowed values.
BRIDGE_LIMITS = {
    **{key.replace("_", "-"): limit for key, limit in BOARD_LIMITS.items()},
    "connections": Limit("connections", 1, 4096),
    "connections-per-host": Limit("connections_per_host", 1, 4096),
    "grace-s": Limit("grace_s", 0, 86400),
}

# The limits of `ros1.graph_limits.GraphLimits`. The lowest values are enough for a few small nodes.
GRAPH_LIMITS = {
    "xmlrpc-bytes": Limit("body_bytes", 65536, 1024 << 20),
    "xmlrpc-connections": Limit("xmlrpc_connections", 8, 65536),
    "xmlrpc-connections-per-host": Limit("xmlrpc_connections_per_host", 4, 65536),
    "xmlrpc-request-s": Limit("xmlrpc_request_s", 1, 3600),
    "parameter-bytes": Limit("parameter_bytes", 1024, 4096 << 20),
    "parameters-bytes": Limit("parameters_bytes", 65536, 4096 << 20),
    # The length of a message on the wire is a uint32.
    "message-bytes": Limit("message_bytes", 1024, 4095 << 20),
    "header-bytes": Limit("header_bytes", 4096, 64 << 20),
    "header-s": Limit("header_s", 1, 3600),
    "tcpros-connections": Limit("tcpros_connections", 8, 65536),
    "tcpros-connections-per-host": Limit("tcpros_connections_per_host", 4, 65536),
}


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
        f"devices.{name} matches no board; add a key to identify it ({', '.join(MATCH_KEYS)}), or append "
        f"?name={name} to an ADDRESS"
        for name in devices.unchosen([link.name for link in links])
    ]


def limit_option(limits: Mapping[str, Limit]) -> Callable[[Function], Function]:
    """Return the option `--limit` for a command with these limits."""
    return add_option(
        "--limit limits NAME=VALUE",
        f"Set a limit; may be repeated. Names: {', '.join(limits)}.",
        multiple=True,
    )


def read_limits(texts: Sequence[str]) -> tuple[BridgeSettings, GraphLimits]:
    """Return the bridge's and the graph's limits. Raises ConfigError."""
    from rostether.bridge.settings import DEFAULT_SETTINGS

    given = _read(texts, {**BRIDGE_LIMITS, **GRAPH_LIMITS})
    bridge = {BRIDGE_LIMITS[name].setting: value for name, value in given.items() if name in BRIDGE_LIMITS}
    return replace(DEFAULT_SETTINGS, **bridge), _graph_limits(given)


def read_graph_limits(texts: Sequence[str]) -> GraphLimits:
    """Return the graph's limits, for commands that have no others. Raises ConfigError."""
    return _graph_limits(_read(texts, GRAPH_LIMITS))


def _graph_limits(given: Mapping[str, float]) -> GraphLimits:
    graph = {GRAPH_LIMITS[name].setting: value for name, value in given.items() if name in GRAPH_LIMITS}
    return replace(DEFAULT_GRAPH_LIMITS, **graph)


def _read(texts: Sequence[str], limits: Mapping[str, Limit]) -> dict[str, float]:
    given: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        limit = limits.get(name)
        if limit is None or not equals:
            raise ConfigError(f"--limit {text}: write NAME=VALUE, where NAME is one of {', '.join(limits)}")
        is_fractional = may_be_fractional(name.replace("-", "_"))
        try:
            number = float(value) if is_fractional else int(value)
        except ValueError:
            number = float("nan")
        if not limit.lowest <= number <= limit.highest:
            kind = "a number" if is_fractional else "a whole number"
            raise ConfigError(f"--limit {text}: use {kind} from {limit.lowest:g} to {limit.highest:.10g}")
        given[name] = number
    return given
