"""The nodes of topic_tools as roles: relay, throttle, mux and the commands of a mux."""

from __future__ import annotations

import time
from collections.abc import Callable

import click

from rostether.cli.role.node import role
from rostether.cli.shell.output import write_line
from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.anonymous import anonymous_name
from rostether.names.remap import Arguments
from rostether.nodes.forwarding import ByteThrottle, MessageThrottle, forward
from rostether.nodes.mux import Mux

# A mux answers immediately; a user does not wait longer.
_CALL_LIMIT_S = 10.0
# More are a mistake, such as `*` that a shell has expanded.
_MAX_MUX_TOPICS = 1_000
_METAVAR = "ARGUMENT..."


def _relay_topics(arguments: Arguments) -> tuple[str, str]:
    source, *target = _words(arguments, 1, 2, "relay IN [OUT]")
    return source, target[0] if target else f"{source}_relay"


@role(
    "relay",
    "rostether role relay /chatter /copy",
    metavar=_METAVAR,
    node_name=lambda _, arguments: _unique_name(_relay_topics(arguments)[0], "relay"),
)
async def relay(graph: TypedGraph, arguments: Arguments) -> None:
    """Publish IN again as OUT (default: IN_relay): relay IN [OUT] [_lazy:=true].

    With _lazy:=true it subscribes to IN only while OUT has a subscriber.
    """
    source, target = _relay_topics(arguments)
    await forward(graph.raw, source, target, lazy=await _flag(graph, "lazy"))


def _throttle_words(arguments: Arguments) -> tuple[str, str, list[float]]:
    """Return IN, OUT, and the limits: HZ, or BYTES_PER_SECOND and WINDOW_SECONDS."""
    usage = "throttle messages IN HZ [OUT], or throttle bytes IN BYTES_PER_SECOND WINDOW_SECONDS [OUT]"
    rest = _words(arguments, 3, 5, usage)
    count = {"messages": 3, "bytes": 4}.get(rest[0])
    if count is None or len(rest) not in (count, count + 1):
        raise ConfigError(f"write {usage}")
    target = rest[count] if len(rest) > count else f"{rest[1]}_throttle"
    return rest[1], target, [_number(each, usage) for each in rest[2:count]]


@role(
    "throttle",
    """
    rostether role throttle messages /scan 5 /scan_slow
    rostether role throttle bytes /image 100000 1.0
    """,
    metavar=_METAVAR,
    node_name=lambda _, arguments: _unique_name(_throttle_words(arguments)[0], "throttle"),
)
async def throttle(graph: TypedGraph, arguments: Arguments) -> None:
    """Publish IN again as OUT (IN_throttle), with limited messages or bytes per second.

    Write: throttle messages IN HZ [OUT], or throttle bytes IN BYTES_PER_SECOND WINDOW_SECONDS [OUT].

    With _lazy:=true it publishes only while OUT has a subscriber. With _wall_clock:=true it uses this
    machine's clock instead of ROS time.
    """
    source, target, limits = _throttle_words(arguments)
    is_wall_time = await _flag(graph, "wall_clock")
    now_s: Callable[[], float] = time.time if is_wall_time else lambda: graph.now().to_s()
    limit, *window = limits
    select = ByteThrottle(int(limit), window[0], now_s) if window else MessageThrottle(limit, now_s)
    await forward(graph.raw, source, target, select, lazy=await _flag(graph, "lazy"))


def _mux_topics(arguments: Arguments) -> list[str]:
    return _words(arguments, 2, _MAX_MUX_TOPICS, "mux OUT IN...")


@role(
    "mux",
    "rostether role mux /cmd_vel /joy_vel /plan_vel",
    metavar=_METAVAR,
    node_name=lambda _, arguments: _unique_name(_mux_topics(arguments)[0], "mux"),
)
async def mux(graph: TypedGraph, arguments: Arguments) -> None:
    """Publish one of the topics IN as OUT: mux OUT IN...

    It offers the services mux/select, mux/add, mux/delete and mux/list. Parameters: _lazy:=true,
    _latch:=true, _initial_topic:=IN.
    """
    output, *inputs = _mux_topics(arguments)
    await Mux(
        graph,
        output,
        inputs,
        initial=str(await graph.get_param("~initial_topic", "")),
        lazy=await _flag(graph, "lazy"),
        latch=await _flag(graph, "latch"),
    ).run()


def _mux_command(verb: str, explanation: str, example: str) -> click.Command:
    """Return a command that calls a service of a mux: `VERB MUX TOPIC`, or `list MUX`."""
    parts = ("MUX",) if verb == "list" else ("MUX", "TOPIC")
    kind = f"Mux{verb.capitalize()}"

    def words(arguments: Arguments) -> list[str]:
        return _words(arguments, len(parts), len(parts), f"mux-{verb} {' '.join(parts)}")

    def node_name(_: str, arguments: Arguments) -> str:
        words(arguments)
        return anonymous_name(kind)

    async def call(graph: TypedGraph, arguments: Arguments) -> None:
        name, *topics = words(arguments)
        service = graph.resolve(f"{name}/{verb}")
        request = {"topic": topics[0]} if topics else {}
        answer = await graph.call(service, f"topic_tools/{kind}", request, timeout_s=_CALL_LIMIT_S)
        for each in getattr(answer, "topics", ()):
            write_line(each)

    call.__doc__ = explanation
    examples = f"rostether role mux-{verb} mux {example}".rstrip()
    return role(f"mux-{verb}", examples, metavar=_METAVAR, node_name=node_name)(call)


mux_select = _mux_command(
    "select", "Choose the topic that a mux publishes: mux-select MUX TOPIC; `__none` for none.", "/joy_vel"
)
mux_add = _mux_command("add", "Add an input to a mux: mux-add MUX TOPIC.", "/joy_vel")
mux_delete = _mux_command("delete", "Remove an input from a mux: mux-delete MUX TOPIC.", "/joy_vel")
mux_list = _mux_command("list", "List the inputs of a mux: mux-list MUX.", "")


def _words(arguments: Arguments, lowest: int, highest: int, usage: str) -> list[str]:
    """Return the words of a node's arguments that are not NAME:=VALUE."""
    rest = arguments.rest
    if not lowest <= len(rest) <= highest:
        raise ConfigError(f"write {usage}; given: {' '.join(rest) or 'no arguments'}")
    return rest


def _unique_name(topic: str, suffix: str) -> str:
    return anonymous_name(f"{topic.strip('~/').rpartition('/')[2] or 'topic'}_{suffix}")


def _number(text: str, usage: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"{text!r} is not a number; write {usage}") from None


async def _flag(graph: TypedGraph, name: str) -> bool:
    return bool(await graph.get_param(f"~{name}", False))
