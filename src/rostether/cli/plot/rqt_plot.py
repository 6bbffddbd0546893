"""rqt_plot as a role: without arguments, it plots the published numbers instead of an empty window."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.role.node import RoleVerb
from rostether.cli.shell.output import warn
from rostether.cli.shell.own_command import own_command, replace_process
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError, DefinitionError
from rostether.msgdef.spec import INTEGER_RANGES

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry

# About as many as there are colors; a user who wants more names the fields.
MAX_FIELDS = 8
_NUMBERS = frozenset(INTEGER_RANGES) | {"float32", "float64", "bool"}
# Topics of the system, whose numbers are rarely of interest.
_NOT_PLOTTED = ("/rosout", "/rosout_agg", "/clock", "/diagnostics", "/tf", "/tf_static")


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
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.msgdef.registry import Registry

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
