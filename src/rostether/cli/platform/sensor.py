"""`rostether sensor`: the sensors that /sensing_manager knows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from rostether.cli.access.either_graph import joined_either
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.shell.output import json_option, write_json, write_line, write_table
from rostether.cli.shell.verbs import verb, verb_group
from rostether.errors import GraphError
from rostether.graph.typed_graph import TypedGraph
from rostether.serde.values import Message

# The list is latched: the manager sends it immediately. A busy Raspberry Pi needs seconds to connect.
_LIMIT_S = 10.0


sensor = verb_group(
    "sensor",
    "List, show and rename the sensors of all platforms.",
    {
        "list": ("sensor:list_sensors", "List the sensors by platform."),
        "show": ("sensor:show", "Show one sensor."),
        "rename": ("sensor:rename", "Give a sensor another name."),
    },
    """
    rostether sensor list
    rostether sensor show sensor_node0
    rostether sensor rename sensor_node0 "Front camera"
    """,
    package="rostether.cli.platform",
)


@verb("list", "rostether sensor list")
@json_option
@graph_options(allow=True)
async def list_sensors(as_json: bool, graph: GraphOptions) -> None:
    """List the sensors by platform: id, type, state, topic and name, with the reason for the state."""
    sensors = [_plain(each) for each in await _joined_sensors(graph)]
    if as_json:
        for each in sensors:
            write_json(each)
        return
    if not sensors:
        write_line("no sensor is registered")
    for platform in sorted({each["platform_name"] for each in sensors}):
        write_line(platform)
        write_table([_cells(each) for each in sensors if each["platform_name"] == platform], indent="  ")


@verb("show", "rostether sensor show sensor_node0")
@click.argument("sensor_id", metavar="ID")
@json_option
@graph_options(allow=True)
async def show(sensor_id: str, as_json: bool, graph: GraphOptions) -> None:
    """Show one sensor, given its id or its name."""
    found = _plain(_find(await _joined_sensors(graph), sensor_id))
    if as_json:
        write_json(found)
        return
    for key, value in found.items():
        write_line(f"{key.removesuffix('_name').replace('_', ' ')}: {value or '-'}")


@verb("rename", 'rostether sensor rename sensor_node0 "Front camera"')
@click.argument("sensor_id", metavar="ID")
@click.argument("name")
@graph_options(allow=True)
async def rename(sensor_id: str, name: str, graph: GraphOptions) -> None:
    """Give a sensor another NAME; its id and its topic stay the same."""
    async with joined_either(graph, purpose="sensor") as (node, _):
        found = _find(await _sensors(node), sensor_id)
        request: Mapping[str, Any] = {"id": found.id, "name": name}
        await node.call("sensors_rename", "sensing_platform/RenameSensor", request, timeout_s=_LIMIT_S)
    write_line(f"{found.id}: {name}")


async def _joined_sensors(graph: GraphOptions) -> list[Message]:
    async with joined_either(graph, purpose="sensor") as (node, _):
        return await _sensors(node)


async def _sensors(node: TypedGraph) -> list[Message]:
    """Return the sensors in the manager's list. Raises GraphError without a manager."""
    try:
        message = await node.wait_for_message("sensors", "sensing_platform/Sensors", timeout_s=_LIMIT_S)
    except TimeoutError:
        raise GraphError(
            "no sensing manager publishes its sensors; start one with: rostether role sensing-manager"
        ) from None
    return list(message.sensors)


def _find(sensors: list[Message], wanted: str) -> Message:
    found = [each for each in sensors if each.id == wanted] or [
        each for each in sensors if each.name == wanted
    ]
    if len(found) != 1:
        reason = "several sensors have the name" if found else "no sensor has the id or the name"
        raise GraphError(f"{reason} {wanted!r}; see: rostether sensor list")
    return found[0]


def _cells(row: Mapping[str, Any]) -> list[str]:
    reason = f" ({row['state_text']})" if row["state_text"] else ""
    return [*(row[key] for key in ("id", "sensor_type", "state", "topic")), f"{row['name']}{reason}"]


def _plain(found: Message) -> dict[str, Any]:
    # A time is not a value of JSON.
    return {name: getattr(found, name) for name, _ in found._fields if name != "state_since"}
