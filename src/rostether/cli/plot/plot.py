"""`rostether plot`: values of topics over time, live in the terminal or in a picture, like rqt_plot."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from textwrap import shorten

import click

from rostether.cli.access.completions import complete_fields
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.ros1_access import joined, master_client, read_environment
from rostether.cli.plot.curves import MAX_CURVES, expand
from rostether.cli.plot.session import DEFAULT_WINDOW_S, Group, PlotOptions, PlotSession
from rostether.cli.role.node import RoleVerb
from rostether.cli.shell.option_group import option_group
from rostether.cli.shell.output import shows_live, warn
from rostether.cli.shell.own_command import own_command, replace_process
from rostether.cli.shell.picture_files import picture_format
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.cli.topic.misfit_notice import shown_messages
from rostether.cli.topic.ros1_chosen_topic import resolve_with_field, wait_for_topic
from rostether.errors import ConfigError, DefinitionError
from rostether.msgdef.primitives import INTEGER_RANGES
from rostether.msgdef.registry import Registry
from rostether.names.graph_name import is_in_namespace
from rostether.serde.codec import Codec
from rostether.serde.field_path import FieldPath

# About as many as there are colors; a user who wants more names the fields.
MAX_FIELDS = 8
_NUMBERS = frozenset(INTEGER_RANGES) | {"float32", "float64", "bool"}
# Topics of the system, whose numbers are rarely of interest.
_NOT_PLOTTED = ("/rosout", "/rosout_agg", "/clock", "/diagnostics", "/tf", "/tf_static")
# The length that fits above a picture.
MAX_TITLE_CHARACTERS = 90


@verb(
    "plot",
    """
    rostether plot /ultrasound/range
    rostether plot /imu_data/angular_velocity/x:y:z
    rostether plot "/joint_states/position[0:4]" --window 30
    rostether plot /joint_states/position --duration 20 --output joints.png
    """,
    old_options={"--for": "--duration", "--save": "--output"},
)
@click.argument(
    "fields", nargs=-1, required=True, metavar="TOPIC[/FIELD[:FIELD]]...", shell_complete=complete_fields
)
@option_group("options", PlotOptions)
@graph_options(allow=True)
async def plot(fields: tuple[str, ...], options: PlotOptions, graph: GraphOptions) -> None:
    """Plot values of topics over their time of arrival.

    A FIELD is written as for `topic echo`; colons separate more fields of the same message. For an array or a
    message, every number in it is plotted. Without a terminal, the plot is printed once, at the end. The
    command waits for topics that do not exist yet.
    """
    if options.file is not None:
        picture_format(options.file, (".png", ".svg"))
    named = {name for field in fields for name in expand(field)}
    every = (*fields, *(field for field in options.right if not named.issuperset(expand(field))))
    targets = [expand(field) for field in every]
    if sum(map(len, targets)) > MAX_CURVES:
        raise click.UsageError(f"at most {MAX_CURVES} fields can be plotted; give fewer")
    is_terminal = shows_live()
    duration_s = options.duration_s
    if not is_terminal and options.file is None and duration_s is None:
        duration_s = options.window_s or DEFAULT_WINDOW_S
    title = options.title or shorten(", ".join(every), MAX_TITLE_CHARACTERS)
    session = PlotSession(replace(options, duration_s=duration_s, title=title), is_live=is_terminal)
    if graph.ros2 is not None:
        await _plot_ros2(graph, targets, session, options.msg_paths)
    else:
        await _plot_ros1(graph, targets, session, options.msg_paths)


async def _plot_ros1(
    graph_options: GraphOptions, targets: Sequence[Group], session: PlotSession, msg_paths: tuple[Path, ...]
) -> None:
    environment = read_environment(graph_options)
    groups = [[resolve_with_field(target, environment) for target in group] for group in targets]
    async with joined(graph_options, msg_paths, purpose="plot") as graph:

        async def follow(group: Sequence[str]) -> None:
            topic = (await wait_for_topic(group[0], graph, environment)).topic
            here = [name for name in group if is_in_namespace(name, topic)]
            async with asyncio.TaskGroup() as tasks:
                if others := [name for name in group if name not in here]:
                    tasks.create_task(follow(others))
                tasks.create_task(follow_topic(topic, here))

        async def follow_topic(topic: str, group: Sequence[str]) -> None:
            stream = graph.messages(topic)
            codec: Codec | None = None
            paths: dict[str, FieldPath | None] = {}
            async with shown_messages(stream) as messages:
                async for message in messages:
                    if stream.codec is not codec:
                        assert stream.codec is not None
                        codec = stream.codec
                        session.add_type(topic, graph.store.registry, codec)
                        fields = {name: name[len(topic) + 1 :] for name in group}
                        paths = {
                            name: FieldPath(codec, field) if field else None for name, field in fields.items()
                        }
                    for name, path in paths.items():
                        session.add_message(name, message, path)

        await session.run(follow, groups)


async def _plot_ros2(
    graph_options: GraphOptions, targets: Sequence[Group], session: PlotSession, msg_paths: tuple[Path, ...]
) -> None:
    from rostether.cli.access.ros2_tool_node import tool_node
    from rostether.cli.topic.ros2_chosen_topic import choose_ros2_topic

    async with tool_node(graph_options, msg_paths) as tool:

        async def follow(group: Sequence[str]) -> None:
            async with asyncio.TaskGroup() as tasks:
                for name in group:
                    tasks.create_task(follow_one(name))

        async def follow_one(name: str) -> None:
            chosen = await choose_ros2_topic(tool, name)
            session.add_type(chosen.topic, tool.registry, tool.graph.store.codec(chosen.type))
            async with shown_messages(tool.graph.messages(chosen.topic, chosen.type)) as messages:
                async for message in messages:
                    session.add_message(name, message, chosen.path)

        await session.run(follow, targets)


@verb(
    "rqt-plot",
    """
    rostether role rqt-plot
    rostether role rqt-plot /ultrasound/range
    """,
    cls=RoleVerb,
)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="[TOPIC/FIELD]...")
@graph_options(master=False, ros=False)
def rqt_plot(arguments: tuple[str, ...], graph: GraphOptions) -> None:
    """Plot the given fields, or the first numeric fields that are published."""
    fields = list(arguments)
    if not fields:
        fields = run(_published(graph))
        if not fields:
            raise ConfigError("no topic with numbers is published; `rostether topic list` shows all topics")
        warn(f"rostether plot {' '.join(fields)}")
    replace_process(own_command("plot", *fields), os.environ)


async def _published(graph: GraphOptions) -> list[str]:
    async with master_client(read_environment(graph)) as client:
        publishers, _, _ = await client.system_state()
        types = dict(await client.topic_types())
    registry = Registry.from_environment()
    found: list[str] = []
    for topic in sorted(publishers.keys() - set(_NOT_PLOTTED)):
        found += [f"{topic}/{name}" for name in number_fields(types.get(topic, "*"), registry)]
    return found[:MAX_FIELDS]


def number_fields(type_name: str, registry: Registry) -> list[str]:
    """Return the names of a message's own single numbers, without those of its header; none if unknown."""
    try:
        fields = registry.message(type_name).fields
    except DefinitionError:
        return []
    return [each.name for each in fields if str(each.type) in _NUMBERS]
