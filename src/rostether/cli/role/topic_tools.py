"""The nodes of topic_tools as roles: relay, throttle, mux and the commands of a mux."""

from __future__ import annotations

import time
from collections.abc import Callable

import click

from rostether.cli.role.node import RoleVerb, run_role
from rostether.cli.shell.output import write_line
from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.anonymous import anonymous_name
from rostether.names.remap import Arguments, parse_arguments

# A mux answers at once; a user does not wait longer.
_CALL_LIMIT_S = 10.0
_arguments = click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="ARGUMENT...")


@click.command("relay", cls=RoleVerb, examples="rostether role relay /chatter /copy")
@_arguments
def relay(arguments: tuple[str, ...]) -> None:
    """Publish IN again as OUT (default: IN_relay): relay IN [OUT] [_lazy:=true].

    With _lazy:=true it subscribes to IN only while OUT has a subscriber.
    """
    rest = _plain(arguments, 1, 2, "relay IN [OUT]")
    source, target = rest[0], rest[1] if len(rest) == 2 else f"{rest[0]}_relay"

    async def main(graph: TypedGraph, _: Arguments) -> None:
        from rostether.nodes.forwarding import forward

        await forward(graph.raw, source, target, lazy=await _flag(graph, "lazy"))

    run_role(anonymous_name(f"{_last(source)}_relay"), arguments, main)


@click.command(
    "throttle",
    cls=RoleVerb,
    examples="""
    rostether role throttle messages /scan 5 /scan_slow
    rostether role throttle bytes /image 100000 1.0
    """,
)
@_arguments
def throttle(arguments: tuple[str, ...]) -> None:
    """Publish IN again as OUT (IN_throttle), with limited messages or bytes per second.

    Write: throttle messages IN HZ [OUT], or throttle bytes IN BYTES_PER_SECOND WINDOW_SECONDS [OUT].

    With _lazy:=true it publishes only while OUT has a subscriber. With _wall_clock:=true it uses this
    machine's clock instead of ROS time.
    """
    usage = "throttle messages IN HZ [OUT], or throttle bytes IN BYTES_PER_SECOND WINDOW [OUT]"
    rest = _plain(arguments, 3, 5, usage)
    count = {"messages": 3, "bytes": 4}.get(rest[0])
    if count is None or len(rest) not in (count, count + 1):
        raise ConfigError(f"write {usage}")
    source, target = rest[1], rest[count] if len(rest) > count else f"{rest[1]}_throttle"
    limits = [_number(each) for each in rest[2:count]]

    async def main(graph: TypedGraph, _: Arguments) -> None:
        from rostether.nodes.forwarding import ByteRate, MessageRate, forward

        is_wall_time = await _flag(graph, "wall_clock")
        now_s: Callable[[], float] = time.time if is_wall_time else lambda: graph.now().to_s()
        select = MessageRate(limits[0], now_s) if count == 3 else ByteRate(int(limits[0]), limits[1], now_s)
        await forward(graph.raw, source, target, select, lazy=await _flag(graph, "lazy"))

    run_role(anonymous_name(f"{_last(source)}_throttle"), arguments, main)


@click.command("mux", cls=RoleVerb, examples="rostether role mux /cmd_vel /joy_vel /plan_vel")
@_arguments
def mux(arguments: tuple[str, ...]) -> None:
    """Publish one of the topics IN as OUT: mux OUT IN...

    Services mux/select, mux/add, mux/delete and mux/list; _lazy:=true, _latch:=true, _initial_topic:=IN.
    """
    rest = _plain(arguments, 2, 1_000, "mux OUT IN...")

    async def main(graph: TypedGraph, _: Arguments) -> None:
        from rostether.nodes.mux import Mux

        initial = await graph.get_param("~initial_topic", "")
        await Mux(
            graph,
            rest[0],
            rest[1:],
            initial=str(initial),
            lazy=await _flag(graph, "lazy"),
            latch=await _flag(graph, "latch"),
        ).run()

    run_role(anonymous_name(f"{_last(rest[0])}_mux"), arguments, main)


def _mux_command(verb: str, explanation: str, example: str) -> click.Command:
    """Return a command that calls a service of a mux: `VERB MUX TOPIC`, or `list MUX`."""
    parts = ("MUX",) if verb == "list" else ("MUX", "TOPIC")

    @click.command(
        f"mux-{verb}",
        cls=RoleVerb,
        help=explanation,
        examples=f"rostether role mux-{verb} mux {example}".rstrip(),
    )
    @_arguments
    def command(arguments: tuple[str, ...]) -> None:
        name, *topic = _plain(arguments, len(parts), len(parts), f"mux_{verb} {' '.join(parts)}")
        _call(arguments, f"{name}/{verb}", f"Mux{verb.capitalize()}", *topic)

    return command


mux_select = _mux_command(
    "select", "Choose the topic that a mux publishes: mux-select MUX TOPIC; `__none` for none.", "/joy_vel"
)
mux_add = _mux_command("add", "Add an input to a mux: mux-add MUX TOPIC.", "/joy_vel")
mux_delete = _mux_command("delete", "Remove an input from a mux: mux-delete MUX TOPIC.", "/joy_vel")
mux_list = _mux_command("list", "List the inputs of a mux: mux-list MUX.", "")


def _call(arguments: tuple[str, ...], service: str, kind: str, topic: str | None = None) -> None:
    async def main(graph: TypedGraph, _: Arguments) -> None:
        request = {} if topic is None else {"topic": topic}
        answer = await graph.call(
            graph.resolve(service), f"topic_tools/{kind}", request, timeout_s=_CALL_LIMIT_S
        )
        for each in getattr(answer, "topics", ()):
            write_line(each)

    run_role(anonymous_name(kind), arguments, main)


def _plain(arguments: tuple[str, ...], least: int, most: int, usage: str) -> list[str]:
    rest = parse_arguments(arguments).rest
    if not least <= len(rest) <= most:
        raise ConfigError(f"write {usage}; given: {' '.join(rest) or 'no arguments'}")
    return rest


def _last(topic: str) -> str:
    return topic.strip("~/").rpartition("/")[2] or "topic"


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"{text!r} is not a number") from None


async def _flag(graph: TypedGraph, name: str) -> bool:
    return bool(await graph.get_param(f"~{name}", False))
