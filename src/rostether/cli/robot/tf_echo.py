"""`rostether tf echo`: prints the transform between two frames, like tf_echo."""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.option_group import (
    COUNT,
    POSITIVE,
    NumberRange,
    argument,
    option,
    option_group,
    shared,
)
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import escape_line

if TYPE_CHECKING:
    from rostether.robot.transform import StampedTransform

# Faster than a person can read; a script that needs every message echoes /tf.
MAX_RATE_HZ = 1_000.0
# Transforms of a running robot arrive sooner; until then, nothing is reported.
_SILENT_S = 1.0
# How often the time limit is checked while nothing arrives.
_POLL_S = 0.2


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
def echo(options: EchoOptions, graph: GraphOptions) -> int:
    """Print the pose of the frame CHILD in the frame PARENT, RATE times a second (default: 1).

    Translations are in meters. Rotations are shown as a quaternion and as roll, pitch and yaw. The command
    waits for frames that are not known yet.
    """
    return run(_echo(options, graph))


async def _echo(options: EchoOptions, graph: GraphOptions) -> int:
    from rostether.cli.access.either_graph import joined_either
    from rostether.errors import TransformError
    from rostether.robot.tf_listener import tf_listener

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
                    problem = str(error).strip().splitlines()[0]
                    waited_s = loop.time() - began_s
                    if not shown_count and timeout_s is not None and waited_s >= timeout_s:
                        warn(escape_line(problem))
                        return EXIT_FAILED
                    if problem != reported and waited_s >= _SILENT_S:
                        reported = problem
                        warn(f"waiting: {escape_line(problem)}")
                    listener.arrived.clear()
                    with contextlib.suppress(TimeoutError):
                        async with asyncio.timeout(_POLL_S):
                            await listener.arrived.wait()
                    continue
                _show(stamped, options.as_json)
                shown_count += 1
                reported = ""
                due_s = max(due_s + 1 / options.rate_hz, loop.time())
                if shown_count != count:
                    await asyncio.wait([left], timeout=due_s - loop.time())
        finally:
            left.cancel()
    return EXIT_DONE


def _show(stamped: StampedTransform, as_json: bool) -> None:
    from rostether.robot.tf_report import format_transform
    from rostether.robot.transform import rpy_from_quaternion

    if not as_json:
        write_line(format_transform(stamped))
        return
    write_json(
        {
            "parent": stamped.parent,
            "child": stamped.child,
            "stamp_s": stamped.stamp_ns / 1e9,
            "translation_m": stamped.transform.translation,
            "rotation_xyzw": stamped.transform.rotation,
            "rpy_rad": rpy_from_quaternion(stamped.transform.rotation),
        }
    )
