"""`rostether relay`: relays topics, services and actions between a ROS 1 graph and a ROS 2 graph."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options, installed_middleware
from rostether.cli.access.options import listen_option, msg_path_option
from rostether.cli.access.ros1_access import master_client, read_environment, ros1_join
from rostether.cli.access.ros2_access import ros2_access
from rostether.cli.access.served_graphs import check_master, native_session, used_master
from rostether.cli.shell.option_group import PORT, argument, option, option_group
from rostether.cli.shell.verbs import verb
from rostether.errors import UnknownTypeError
from rostether.graph.ports import Level
from rostether.mechanisms.block_end import closed_at_end
from rostether.msgdef.interface import ANY_TYPE, ServiceType
from rostether.names.graph_name import validate_name
from rostether.relay.relay_filter import RelayDirection, RelayFilter, ServiceFilter, TopicFilter
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.leftovers import Leftovers
from rostether.ros1.node.service_probe import probe_type

if TYPE_CHECKING:
    from rostether.relay.side import FindServiceType
    from rostether.ros2.types.type_support import Ros2Types

# The characters of patterns, which names do not have.
_WILDCARDS = re.compile(r"[*?!\[\]-]")


@dataclass(frozen=True, slots=True)
class RelayOptions:
    """The options of `relay`."""

    topics: tuple[str, ...] = argument(nargs=-1, metavar="[TOPIC...]")
    to_ros2: tuple[str, ...] = option(
        "--to-ros2 TOPIC", "Relay this topic from ROS 1 to ROS 2 only; may be repeated.", multiple=True
    )
    to_ros1: tuple[str, ...] = option(
        "--to-ros1 TOPIC", "Relay this topic from ROS 2 to ROS 1 only; may be repeated.", multiple=True
    )
    services: tuple[str, ...] = option(
        "--service NAME[=TYPE]",
        "Offer this service in the graph that does not have it; may be repeated.",
        multiple=True,
    )
    actions: tuple[str, ...] = option(
        "--action NAME",
        "Offer this action in the graph that does not have it; may be repeated.",
        multiple=True,
    )
    master_port: int | None = option(
        "--master-port PORT",
        "Port for the ROS 1 master, started if none runs (default: that of ROS_MASTER_URI, or 11311).",
        type=PORT,
    )

    def choice(self) -> RelayFilter:
        """Return the requested relay; names are full names, with or without the leading slash.

        Raises InvalidNameError.
        """
        return RelayFilter(
            (
                *(TopicFilter(_full(name)) for name in self.topics),
                *(TopicFilter(_full(name), RelayDirection.FIRST_TO_SECOND) for name in self.to_ros2),
                *(TopicFilter(_full(name), RelayDirection.SECOND_TO_FIRST) for name in self.to_ros1),
            ),
            tuple(
                ServiceFilter(_full(name), kind)
                for name, _, kind in (each.partition("=") for each in self.services)
            ),
            tuple(_full(name) for name in self.actions),
        )


@verb(
    "relay",
    """
    rostether relay /chatter /odom                       both ways, with the installed ROS 2
    rostether relay --ros2 zenoh --to-ros2 "/sensors/*" --to-ros1 /cmd_vel
    rostether relay /tf /tf_static --service /enable --service /plan=nav_msgs/GetPlan
    rostether relay --action /move_base --msg-path ~/my_msgs
    rostether relay --to-ros1 /clock                     /clock and /rosout need their full names
    """,
    is_service=True,
)
@option_group("options", RelayOptions)
@graph_options(served=True)
@listen_option
@msg_path_option
async def relay(
    options: RelayOptions, listen: str | None, msg_paths: tuple[Path, ...], graph: GraphOptions
) -> None:
    """Relay topics, services and actions between ROS 1 and ROS 2.

    A TOPIC is relayed in both directions while it has a publisher; * in a name matches anything. Types are
    converted as for boards; ROS 1 types unknown to ROS 2 keep their name there. The command always uses both
    graphs: without --ros2, it uses an installed rclpy, else zenoh.
    """
    choice = options.choice()
    if not (choice.topics or choice.services or choice.actions):
        raise click.UsageError("give topics to relay, services with --service, or actions with --action")
    check_master(graph, options.master_port)
    environment = read_environment(graph, listen)
    # A relay always uses both graphs.
    both = replace(graph, ros2=graph.ros2 or installed_middleware())
    report = ConsoleReporter().report
    await relay_between(
        environment, both, choice, report, master_port=options.master_port, msg_paths=msg_paths
    )


async def relay_between(
    environment: RosEnvironment,
    graph: GraphOptions,
    choice: RelayFilter,
    report: Callable[[Level, str], None],
    *,
    master_port: int | None = None,
    msg_paths: Sequence[Path] = (),
) -> None:
    """Relay until canceled; `report` gets lines for the user.

    Without `master_port`, a new ROS 1 master has the port of the environment's URI. Raises GraphError,
    ConfigError, and UnknownTypeError for a service.
    """
    from rostether.relay.relay import Relay
    from rostether.relay.side import RelaySide
    from rostether.ros2.actions.board_graph import BoardJoin

    assert graph.ros2 is not None
    name = graph.node_name("relay")
    async with (
        used_master(environment, is_chosen=graph.master is not None, port=master_port) as used,
        ros2_access(graph.ros2, msg_paths, reach=graph.zenoh, params_files=graph.params_files) as access,
    ):
        for line in (used.line, access.line):
            report(Level.INFO, line)
        await access.types.searched()

        async def probe(service: str) -> str:
            async with master_client(used.environment) as client:
                return await probe_type(client, service)

        find = finding_types(access.types)
        # A type that no package defines is an error before the relay starts.
        for service in choice.services:
            if service.type:
                await find(service.pattern, service.type)
        async with (
            closed_at_end(await ros1_join(used.environment)(name)) as ros1,
            closed_at_end(await access.join(name)) as ros2,
            closed_at_end(
                BoardJoin(access.join, access.types, partial(native_session, graph, msg_paths))
            ) as actions,
        ):
            leftovers = Leftovers(used.environment.master_uri, ros1.node_name)
            sides = (
                RelaySide("ROS 1", ros1, finding_types(access.types, probe), leftovers.forget_if_gone),
                RelaySide("ROS 2", ros2, find),
            )
            await Relay(*sides, choice, report, actions).run()


def finding_types(types: Ros2Types, probe: Callable[[str], Awaitable[str]] | None = None) -> FindServiceType:
    """Return a function that finds a service's type: by its name in either ROS, or with `probe`.

    `probe` asks the server of a service for the name of the type.
    """

    async def find(service: str, name: str) -> ServiceType:
        if name == ANY_TYPE and probe is not None:
            name = await probe(service)
        if name == ANY_TYPE or " " in name:
            found = "" if name == ANY_TYPE else f" (it may be {name})"
            raise UnknownTypeError(
                f"the type of the service {service} is unknown{found}; give it as --service {service}=TYPE"
            )
        package, _, short_name = name.partition("/")
        if not short_name.startswith("srv/"):
            try:
                return types.registry.service_type(name)
            except UnknownTypeError:
                pass  # A ROS 2 package may define it.
        return types.service_by_name(f"{package}/srv/{short_name.removeprefix('srv/')}").ros1_type

    return find


def _full(name: str) -> str:
    validate_name(_WILDCARDS.sub("x", name))
    return name if name.startswith(("/", "*")) else f"/{name}"
