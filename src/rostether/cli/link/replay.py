"""`rostether link replay`: a capture played into the graph as if its board were there."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.master_choice import used_master
from rostether.cli.access.options import msg_path_option
from rostether.cli.access.ros1_access import joining_ros1, read_environment
from rostether.cli.bridge.serving import bridge
from rostether.cli.shell.output import write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import ConfigError
from rostether.graph.ports import Level
from rostether.ros1.environment import RosEnvironment
from rostether.transports.address import Address, TcpAddress
from rostether.transports.peers import PeerEntry

if TYPE_CHECKING:
    from rostether.bridge.supervisor import Supervisor
    from rostether.transports.capture import Capture
    from rostether.transports.replay import CaptureListener
    from rostether.transports.transport import Transport

SUBSCRIBE_S = 0.5
"""How long subscribers get to connect to a new topic when a capture is played without pauses."""

AFTER_S = 1.0
"""How long the node stays behind the last byte, so that subscribers get all."""


@click.command(
    "replay",
    cls=Verb,
    examples="""
    rostether link replay problem.jsonl
    rostether link replay problem.jsonl --speed 4 --name arm
    rostether link replay problem.jsonl --fast
    """,
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--speed",
    type=click.FloatRange(min=0.01, max=1000.0),
    default=1.0,
    metavar="FACTOR",
    help="How many times as fast as it was recorded (1).",
)
@click.option("--fast", is_flag=True, help="Without pauses, but for half a second behind each new topic.")
@click.option("--name", metavar="NAME", help="The board's node name (default: the file's).")
@graph_options(ros=False)
@msg_path_option
def link_replay(
    file: Path,
    speed: float,
    fast: bool,
    name: str | None,
    graph: GraphOptions,
    msg_paths: tuple[Path, ...],
) -> None:
    """Play what the board said, at the times it did, and end with the capture.

    The graph sees the board's topics as if it were there. What is sent to it goes nowhere: a capture cannot
    answer. Like `serve` this is the ROS master when none answers.
    """
    from rostether.names.graph_name import validate_name
    from rostether.transports.capture import Capture

    capture = Capture(file)
    node_name = name if name is not None else _node_name(file)
    validate_name(node_name)
    run(
        _replay(
            read_environment(graph),
            graph.master is not None,
            capture,
            node_name,
            None if fast else speed,
            msg_paths,
        ),
        is_service=True,
    )


async def _replay(
    environment: RosEnvironment,
    is_chosen: bool,
    capture: Capture,
    name: str,
    speed: float | None,
    msg_paths: Sequence[Path],
) -> None:
    from rostether.transports.replay import CaptureListener

    reporter = ConsoleReporter()
    listeners: list[CaptureListener] = []
    settling: list[_Settling] = []

    async def settle() -> None:
        for each in settling:
            await each.settle()

    async def listen(
        address: Address, on_transport: Callable[[Transport], None], *, entry: PeerEntry | None = None
    ) -> CaptureListener:
        listeners.append(CaptureListener(capture, on_transport, speed=speed, settle=settle))
        return listeners[-1]

    async with used_master(environment, is_chosen=is_chosen) as used:
        reporter.line(Level.INFO, used.line)
        # The address only carries the name.
        addresses = [TcpAddress("capture", 0, name=name)]
        async with bridge(
            joining_ros1(used.environment),
            addresses,
            reporter,
            msg_paths=msg_paths,
            diagnostics=True,
            listen=listen,
        ) as supervisor:
            settling.append(_Settling(supervisor))
            (listener,) = listeners
            await listener.play()
            await asyncio.sleep(AFTER_S)
            messages = sum(each.message_count for board in supervisor.boards() for each in board.endpoints)
            topics = sum(len(board.endpoints) for board in supervisor.boards())
    if not listener.played_bytes:
        raise ConfigError(f"{capture.path} holds no byte of a board; record it while the board is connected")
    write_line(f"played {listener.played_bytes} bytes: {topics} topics and services, {messages} messages")


class _Settling:
    """Waits until the bridge has taken a chunk, and for subscribers when it made a new topic of it."""

    def __init__(self, supervisor: Supervisor) -> None:
        self._supervisor = supervisor
        self._known = 0

    async def settle(self) -> None:
        """Wait."""
        await asyncio.sleep(0)
        known = sum(len(board.endpoints) for board in self._supervisor.boards())
        if known > self._known:
            await asyncio.sleep(SUBSCRIBE_S)
        self._known = known


def _node_name(file: Path) -> str:
    name = re.sub(r"\W", "_", file.stem, flags=re.ASCII).strip("_")
    return name if name[:1].isalpha() else f"board_{name}".rstrip("_")
