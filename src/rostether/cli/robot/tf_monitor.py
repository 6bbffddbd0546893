"""`rostether tf monitor`: the delay and rate of transforms, like tf_monitor."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.shell.option_group import COUNT, add_option
from rostether.cli.shell.output import json_option, write_json, write_line, write_result
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.run_until import run_until
from rostether.mechanisms.text import escape_line

if TYPE_CHECKING:
    from rostether.robot.tf_buffer import TransformBuffer
    from rostether.robot.tf_statistics import TfStatistics

# The period of tf_monitor.
REPORT_PERIOD_S = 1.0


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
def monitor(frames: tuple[str, ...], count: int | None, as_json: bool, graph: GraphOptions) -> None:
    """Report every second which node broadcasts each frame, and how late.

    With PARENT and CHILD, report only the frames between them.
    """
    if len(frames) not in (0, 2):
        raise click.UsageError("give PARENT and CHILD, or no frame")
    run(_monitor(tuple(each.removeprefix("/") for each in frames), count, as_json, graph))


async def _monitor(frames: tuple[str, ...], count: int | None, as_json: bool, graph: GraphOptions) -> None:
    from rostether.cli.access.either_graph import joined_either
    from rostether.robot.tf_listener import tf_listener
    from rostether.robot.tf_statistics import TfStatistics
    from rostether.robot.transform import StampedTransform

    statistics = TfStatistics()
    async with joined_either(graph, purpose="tf_monitor") as (node, _), tf_listener(node) as listener:

        def add(transforms: Sequence[StampedTransform], authority: str, is_static: bool) -> None:
            statistics.add(transforms, authority, is_static, node.now().to_ns())

        async def report() -> None:
            for _ in itertools.count() if count is None else range(count):
                await asyncio.sleep(REPORT_PERIOD_S)
                _report(listener.buffer, statistics, frames, as_json)

        listener.on_transforms = add
        await run_until(report(), node.raw.wait_closed())


def _report(
    buffer: TransformBuffer, statistics: TfStatistics, frames: tuple[str, ...], as_json: bool
) -> None:
    chain: list[str] = []
    if frames:
        from rostether.errors import TransformError

        try:
            chain = buffer.chain(frames[0], frames[1])
        except TransformError as error:
            problem = escape_line(str(error).strip().splitlines()[0])
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
