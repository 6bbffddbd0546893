"""`rostether tf echo`, `monitor` and `tree`: the transforms between frames, like tf_echo and tf_monitor."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import click
from msgspec.structs import asdict

from rostether.cli.access.either_graph import joined_either
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import (
    COUNT,
    POSITIVE,
    NumberRange,
    add_flag,
    add_option,
    argument,
    option,
    option_group,
    shared,
)
from rostether.cli.shell.output import json_option, paint_frame, warn, write_json, write_line, write_result
from rostether.cli.shell.verbs import verb
from rostether.errors import TransformError
from rostether.mechanisms.tasks import occurs_within, run_until
from rostether.mechanisms.text import escape_line
from rostether.robot.tf_buffer import TransformBuffer
from rostether.robot.tf_listener import tf_listener
from rostether.robot.tf_report import format_transform, frame_facts, frame_tree, frames_as_dot
from rostether.robot.tf_statistics import TfStatistics
from rostether.robot.transform import StampedTransform, rpy_from_quaternion

# Faster than a person can read; a script that needs every message echoes /tf.
MAX_RATE_HZ = 1_000.0
# Transforms of a running robot arrive sooner; until then, nothing is reported.
_SILENT_S = 1.0
# How often the time limit is checked while nothing arrives.
_POLL_S = 0.2
# The period of tf_monitor.
REPORT_PERIOD_S = 1.0
# Long enough for transforms at 1 Hz, and to measure a rate.
DEFAULT_LISTENING_S = 2.0
# More lines would push the tree off the screen.
_MAX_REFUSALS = 20


@dataclass(frozen=True, slots=True)
class EchoOptions:
    """The options of `tf echo`."""

    parent: str = argument()
    child: str = argument()
    rate_hz: float = argument(metavar="[RATE]", type=NumberRange(0, MAX_RATE_HZ, min_open=True), default=1.0)
    count: int | None = option("-n --count COUNT", "Stop after COUNT transforms.", type=COUNT)
    timeout_s: float | None = option(
        "--timeout SECONDS", "Give up if no transform is available after SECONDS.", type=POSITIVE
    )
    as_json: bool = shared(json_option, False)


@verb(
    "echo",
    """
    rostether tf echo base_link gripper
    rostether tf echo base_link gripper 10
    rostether tf echo -n 1 --json base_link gripper
    """,
)
@option_group("options", EchoOptions)
@graph_options(allow=True)
async def echo(options: EchoOptions, graph: GraphOptions) -> int:
    """Print the pose of the frame CHILD in the frame PARENT, RATE times a second (default: 1).

    Translations are in meters. Rotations are shown as a quaternion and as roll, pitch and yaw. The command
    waits for frames that are not known yet.
    """
    async with joined_either(graph, purpose="tf_echo") as (node, _), tf_listener(node) as listener:
        parent, child = options.parent.removeprefix("/"), options.child.removeprefix("/")
        timeout_s, count = options.timeout_s, options.count
        loop = asyncio.get_running_loop()
        began_s = due_s = loop.time()
        reported, shown_count = "", 0
        left = asyncio.ensure_future(node.raw.wait_closed())
        try:
            while shown_count != count and not left.done():
                try:
                    stamped = listener.buffer.lookup(parent, child)
                except TransformError as error:
                    problem = _first_line(error)
                    waited_s = loop.time() - began_s
                    if not shown_count and timeout_s is not None and waited_s >= timeout_s:
                        warn(problem)
                        return EXIT_FAILED
                    if problem != reported and waited_s >= _SILENT_S:
                        reported = problem
                        warn(f"waiting: {problem}")
                    listener.arrived.clear()
                    await occurs_within(listener.arrived, _POLL_S)
                    continue
                write_result(_record(stamped), format_transform(stamped), as_json=options.as_json)
                shown_count += 1
                reported = ""
                due_s = max(due_s + 1 / options.rate_hz, loop.time())
                if shown_count != count:
                    await asyncio.wait([left], timeout=due_s - loop.time())
        finally:
            left.cancel()
    return EXIT_DONE


def _first_line(error: TransformError) -> str:
    return escape_line(str(error).strip().splitlines()[0])


def _record(stamped: StampedTransform) -> dict[str, object]:
    return {
        "parent": stamped.parent,
        "child": stamped.child,
        "stamp_s": stamped.stamp_ns / 1e9,
        "translation_m": stamped.transform.translation,
        "rotation_xyzw": stamped.transform.rotation,
        "rpy_rad": rpy_from_quaternion(stamped.transform.rotation),
    }


@verb(
    "monitor",
    """
    rostether tf monitor
    rostether tf monitor base_link gripper
    rostether tf monitor -n 1 --json
    """,
)
@click.argument("frames", nargs=-1, metavar="[PARENT CHILD]")
@add_option("-n --count COUNT", "Stop after COUNT reports.", type=COUNT)
@json_option
@graph_options(allow=True)
async def monitor(frames: tuple[str, ...], count: int | None, as_json: bool, graph: GraphOptions) -> None:
    """Report every second which node broadcasts each frame, and how late.

    With PARENT and CHILD, report only the frames between them.
    """
    if len(frames) not in (0, 2):
        raise click.UsageError("give PARENT and CHILD, or no frame")
    ends = tuple(each.removeprefix("/") for each in frames)
    statistics = TfStatistics()
    async with joined_either(graph, purpose="tf_monitor") as (node, _), tf_listener(node) as listener:

        def add(transforms: Sequence[StampedTransform], authority: str, is_static: bool) -> None:
            statistics.add(transforms, authority, is_static, node.now().to_ns())

        async def report() -> None:
            for _ in itertools.count() if count is None else range(count):
                await asyncio.sleep(REPORT_PERIOD_S)
                _report(listener.buffer, statistics, ends, as_json)

        listener.on_transforms = add
        await run_until(report(), node.raw.wait_closed())


def _report(
    buffer: TransformBuffer, statistics: TfStatistics, frames: tuple[str, ...], as_json: bool
) -> None:
    chain: list[str] = []
    if frames:
        try:
            chain = buffer.chain(frames[0], frames[1])
        except TransformError as error:
            problem = _first_line(error)
            write_result({"problem": problem}, f"waiting: {problem}", as_json=as_json)
            return
    rows = {name: row for name, row in sorted(statistics.frames.items()) if not frames or name in chain}
    if as_json:
        for name, row in rows.items():
            write_json(
                {
                    "frame": name,
                    "broadcaster": row.broadcaster,
                    "rate_hz": row.rate_hz,
                    "average_delay_s": row.average_s,
                    "max_delay_s": row.max_s,
                }
            )
        return
    write_line(f"\nRESULTS: for {f'{frames[0]} to {frames[1]}' if frames else 'all Frames'}")
    if frames:
        write_line(f"Chain is: {escape_line(' -> '.join(chain))}")
    write_line("Frames:")
    for name, row in rows.items():
        write_line(
            f"Frame: {escape_line(name)} published by {escape_line(row.broadcaster)} "
            f"Average Delay: {row.average_s:.6g} Max Delay: {row.max_s:.6g}"
        )
    write_line("\nAll Broadcasters:")
    for name, row in sorted(statistics.nodes.items()):
        write_line(
            f"Node: {escape_line(name)} {row.rate_hz:.6g} Hz, "
            f"Average Delay: {row.average_s:.6g} Max Delay: {row.max_s:.6g}"
        )


@verb(
    "tree",
    """
    rostether tf tree
    rostether tf tree --duration 10
    rostether tf tree --ros2
    rostether tf tree --dot | dot -Tpdf > frames.pdf
    """,
    old_options={"--time": "--duration"},
)
@add_option(
    "--duration listening_s SECONDS",
    f"How long to listen (default: {DEFAULT_LISTENING_S:g}).",
    type=POSITIVE,
    default=DEFAULT_LISTENING_S,
)
@add_flag("--dot", "Print the tree for graphviz.")
@json_option
@graph_options(allow=True)
async def tree(listening_s: float, dot: bool, as_json: bool, graph: GraphOptions) -> int:
    """Listen for a while, then show the tree of frames with the nodes that broadcast them."""
    refusals: dict[str, None] = {}

    def note(refusal: str) -> None:
        # Every message may cause the same refusal; the text before the frame is its kind.
        kind = refusal.split(" for frame ")[0]
        if len(refusals) < _MAX_REFUSALS:
            refusals.setdefault(kind)

    async with (
        joined_either(graph, purpose="view_frames") as (node, _),
        tf_listener(node, on_refusal=note) as listener,
    ):
        await asyncio.sleep(listening_s)
        buffer = listener.buffer
    for refusal in refusals:
        warn(escape_line(refusal))
    if not buffer.frames:
        warn(
            f"no transform was received within {listening_s:g} s; "
            "start robot_state_publisher or `rostether tf static`, which publish transforms"
        )
        return EXIT_FAILED
    if as_json:
        for facts in frame_facts(buffer):
            write_json(asdict(facts))
    elif dot:
        write_line(frames_as_dot(buffer))
    else:
        for line in frame_tree(buffer):
            write_line(escape_line(line), paint_frame)
    return EXIT_DONE
