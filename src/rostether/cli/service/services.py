"""The interface of `rostether service` to a graph."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

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


class Services(Protocol):
    """The services of one graph. Each method is a whole command and raises RostetherError, UsageError."""

    def list_services(self, wanted: ServiceListing) -> None:
        """Print the services."""

    def type_of(self, service: str) -> None:
        """Print the type of a service."""

    def node_of(self, service: str) -> None:
        """Print the node that offers a service."""

    def args(self, service: str, msg_paths: tuple[Path, ...]) -> None:
        """Print the names of a service's arguments."""

    def info(self, service: str, msg_paths: tuple[Path, ...], *, as_json: bool) -> None:
        """Print a service's type and servers; in ROS 1 also its arguments, in ROS 2 its clients."""

    def find(self, type_name: str) -> None:
        """Print the services of a type."""

    def call(self, service: str, values: tuple[str, ...], options: CallOptions) -> None:
        """Call a service and print its response."""
