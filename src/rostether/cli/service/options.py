"""The options of `rostether service`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rostether.cli.access.completions import complete_services
from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.option_group import POSITIVE, argument, flag, option, shared
from rostether.cli.shell.output import json_option


@dataclass(frozen=True, slots=True)
class ServiceListing:
    """The options of `service list`."""

    namespace: str | None = argument(required=False, shell_complete=complete_services)
    nodes: bool = flag("-n --nodes", "Also print the nodes that offer each service.")
    show_types: bool = flag("-t --show-types", "With --ros2, show types.")
    count_services: bool = flag("-c --count-services", "Print only the number.")
    with_hidden: bool = flag("--include-hidden-services", "With --ros2, include hidden services (_name).")
    as_json: bool = shared(json_option, False)


@dataclass(frozen=True, slots=True)
class CallOptions:
    """The options of `service call`; without a time limit it waits as long as the server runs."""

    verbose: bool = flag("-v --verbose", "Also print the request.")
    wait: bool = flag("--wait", "Wait until a node offers the service.")
    timeout_s: float | None = option(
        "--timeout SECONDS",
        "Give up after SECONDS (default: wait as long as the server runs).",
        type=POSITIVE,
    )
    rate_hz: float | None = option(
        "-r --rate HZ", "With --ros2, call repeatedly at this rate.", type=POSITIVE
    )
    as_json: bool = shared(json_option, False)
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())
