"""`rostether topic hz|bw|delay`: the rate, size and age of messages."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click
from msgspec.structs import asdict

from rostether.cli.access.completions import complete_topics
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option, window_option
from rostether.cli.shell.option_group import (
    COUNT,
    add_flag,
    add_option,
    ignored_options,
    option_group,
    shared,
)
from rostether.cli.shell.output import json_option, write_json, write_line, write_result
from rostether.cli.shell.verbs import verb
from rostether.cli.topic.meter import topic_meter
from rostether.graph.message_windows import (
    DEFAULT_BANDWIDTH_WINDOW,
    DelayWindow,
    IntervalWindow,
    SizeWindow,
    format_bandwidth,
    format_delay,
    format_rate,
    format_rate_table,
    format_ros2_bandwidth,
    rate_record,
)

NOTHING_NEW = "no new messages"
_count_option = add_option("-n --count COUNT", "Stop after COUNT reports.", type=COUNT)


@dataclass(frozen=True, slots=True)
class MeterOptions:
    """The options that `hz` and `delay` share."""

    window: int | None = shared(window_option(None), None)
    count: int | None = shared(_count_option, None)
    as_json: bool = shared(json_option, False)
    msg_paths: tuple[Path, ...] = shared(msg_path_option, ())


@verb(
    "hz",
    """
    rostether topic hz /ultrasound
    rostether topic hz -w 100 /ultrasound /imu_data
    rostether topic hz --filter "m.range < 0.5" /ultrasound
    """,
)
@click.argument("topics", metavar="TOPIC...", nargs=-1, required=True, shell_complete=complete_topics)
@add_option(
    "--filter expression EXPRESSION", "Count only messages m for which the Python expression is true."
)
@add_flag("--wall-time", "Use this machine's clock, even in a simulation.")
@option_group("options", MeterOptions)
@ignored_options(flags=["--tcpnodelay"])
@graph_options(allow=True)
async def hz(
    topics: tuple[str, ...],
    expression: str | None,
    wall_time: bool,
    options: MeterOptions,
    graph: GraphOptions,
) -> None:
    """Measure the message rate and print it every second."""
    test: Callable[[object, str], bool] | None = None
    if expression is not None:
        from rostether.expression.compiler import compile_filter

        test = compile_filter(expression)

    meter = topic_meter(
        graph, topics, options.msg_paths, quiet=options.as_json, needs_definitions=test is not None
    )
    async with meter as measuring:
        windows = {name: IntervalWindow(options.window) for name in measuring.names}

        def now_s() -> float:
            return time.time() if wall_time else measuring.graph.now().to_s()

        for name, window in windows.items():
            count = partial(_count, window, now_s)
            if test is None:
                await measuring.add_raw_listener(name, count)
            else:
                measuring.add_listener(name, partial(_count_matching, count, test, name))
        async for _ in measuring.reports(options.count):
            _report_rates(windows, options.as_json)


def _count(window: IntervalWindow, now_s: Callable[[], float], messages: Sequence[object]) -> None:
    # Simulated time is zero until its first message.
    if stamp_s := now_s():
        for _ in messages:
            window.add(stamp_s)


def _count_matching(
    count: Callable[[Sequence[object]], None], test: Callable[..., bool], topic: str, message: object
) -> None:
    if test(message, topic):
        count([message])


def _report_rates(windows: dict[str, IntervalWindow], as_json: bool) -> None:
    spreads = {name: found for name, window in windows.items() if (found := window.report()) is not None}
    if as_json:
        for name, spread in spreads.items():
            write_json(rate_record(name, spread))
    elif not spreads:
        write_line(NOTHING_NEW)
    elif len(windows) == 1:
        write_line(format_rate(*spreads.values()))
    else:
        write_line(format_rate_table(spreads))


@verb("bw", "rostether topic bw /imu_data")
@click.argument("topic", shell_complete=complete_topics)
@window_option(DEFAULT_BANDWIDTH_WINDOW)
@_count_option
@json_option
@graph_options(allow=True)
async def bw(topic: str, window: int, count: int | None, as_json: bool, graph: GraphOptions) -> None:
    """Measure the bandwidth of a topic and print it every second."""
    sizes = SizeWindow(window)

    async with topic_meter(graph, (topic,), quiet=as_json, needs_definitions=False) as measuring:
        name = measuring.names[0]

        def add(payloads: Sequence[bytes]) -> None:
            now_s = time.monotonic()
            for payload in payloads:
                sizes.add(now_s, measuring.size_bytes(name, payload))

        await measuring.add_raw_listener(name, add)
        async for _ in measuring.reports(count):
            found = sizes.report(time.monotonic())
            if found is not None:
                shown = format_ros2_bandwidth if measuring.is_ros2 else format_bandwidth
                write_result({"topic": name, **asdict(found)}, shown(found), as_json=as_json)


@verb("delay", "rostether topic delay /imu_data")
@click.argument("topic", shell_complete=complete_topics)
@option_group("options", MeterOptions)
@ignored_options(flags=["--tcpnodelay"])
@graph_options(allow=True)
async def delay(topic: str, options: MeterOptions, graph: GraphOptions) -> None:
    """Measure the age of messages on arrival, from the stamp in their header."""
    delays = DelayWindow(options.window)

    meter = topic_meter(graph, (topic,), options.msg_paths, quiet=options.as_json, needs_definitions=True)
    async with meter as measuring:
        name = measuring.names[0]

        def add(message: Any) -> None:
            stamp_s = measuring.stamp_s(name, message)
            # Simulated time is zero until its first message.
            if now_s := measuring.graph.now().to_s():
                delays.add(now_s, stamp_s)

        measuring.add_listener(name, add)
        async for _ in measuring.reports(options.count):
            spread = delays.report()
            if spread is not None and options.as_json:
                write_json({"topic": name, **asdict(spread)})
            elif not options.as_json:
                write_line(NOTHING_NEW if spread is None else format_delay(spread))
