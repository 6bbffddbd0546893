"""`rostether link record` and `replay`: a capture of a board's line, and its replay into the graph."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from pathlib import Path

import click

from rostether.bridge.identity import legal_base_name
from rostether.bridge.settings import BoardNodes
from rostether.bridge.supervisor import Links, Supervisor
from rostether.cli.access.completions import complete_ports
from rostether.cli.access.console_reporter import ConsoleReporter
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import ADDRESS_HINTS, listen_option, msg_path_option
from rostether.cli.access.ros1_access import read_environment, ros1_join, type_store
from rostether.cli.access.served_graphs import used_master
from rostether.cli.bag.bridge_recording import record_limit_option
from rostether.cli.bridge.serve import serve
from rostether.cli.bridge.serving import serving
from rostether.cli.shell.option_group import FILE, PATH, NumberRange, add_flag, add_option
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb
from rostether.errors import ConfigError
from rostether.graph.ports import Level
from rostether.mechanisms.text import counted
from rostether.names.graph_name import validate_name
from rostether.transports.address import Address, TcpAddress
from rostether.transports.capture import Capture
from rostether.transports.peers import PeerEntry
from rostether.transports.replay import CaptureListener
from rostether.transports.transport import Transport

# The time for subscribers to connect to a new topic in a replay without pauses.
SUBSCRIBE_S = 0.5

# The longest wait for subscribers that the graph lists: one that has crashed stays listed.
LISTED_S = 5.0

# How often a replay without pauses checks whether the types of new topics are found.
SEARCH_POLL_S = 0.005

# The time from the last byte to the end of the node, in which subscribers receive everything.
AFTER_S = 1.0


@verb(
    "replay",
    """
    rostether link replay problem.jsonl
    rostether link replay problem.jsonl --speed 4 --name arm
    rostether link replay problem.jsonl --fast
    """,
    is_service=True,
)
@click.argument("file", type=PATH)
@add_option(
    "--speed FACTOR",
    "Speed relative to the recording (default: 1).",
    type=NumberRange(min=0.01, max=1000.0),
    default=1.0,
)
@add_flag("--fast", "Replay without pauses, but wait for the subscribers of each new topic.")
@add_option("--name NAME", "The board's node name (default: the name of the file).")
@graph_options(ros=False)
@msg_path_option
async def link_replay(
    file: Path, speed: float, fast: bool, name: str | None, graph: GraphOptions, msg_paths: tuple[Path, ...]
) -> None:
    """Replay the board's bytes with their original timing.

    The board's topics appear on the graph as if it were connected. Messages to the board are discarded. Like
    `serve`, this starts a ROS master if none answers.
    """
    capture = Capture(file)
    node_name = name if name is not None else legal_base_name(file.stem)
    validate_name(node_name)
    reporter = ConsoleReporter()
    listeners: list[CaptureListener] = []
    settling: list[_Settling] = []

    async def settle() -> float:
        return sum([await each.settle() for each in settling])

    async def listen(
        address: Address, on_transport: Callable[[Transport], None], *, entry: PeerEntry | None = None
    ) -> CaptureListener:
        listeners.append(CaptureListener(capture, on_transport, speed=None if fast else speed, settle=settle))
        return listeners[-1]

    async with used_master(read_environment(graph), is_chosen=graph.master is not None) as used:
        reporter.report(Level.INFO, used.line)
        # The address only provides the name.
        addresses = [TcpAddress("capture", 0, name=node_name)]
        supervisor = Supervisor(
            ros1_join(used.environment),
            type_store(msg_paths),
            reporter=reporter,
            nodes=BoardNodes(diagnostics=True),
            links=Links(listen=listen),
        )
        async with serving(supervisor, addresses, reporter):
            settling.append(_Settling(supervisor, is_fast=fast))
            (listener,) = listeners
            await listener.play()
            await asyncio.sleep(AFTER_S)
            endpoints = [each for board in supervisor.boards() for each in board.endpoints]
    if not listener.played_bytes:
        raise ConfigError(
            f"{capture.path} contains no bytes of a board; record it while the board is connected"
        )
    kinds = "topic or service" if len(endpoints) == 1 else "topics and services"
    messages = sum(each.message_count for each in endpoints)
    write_line(
        f"played {listener.played_bytes} bytes: {len(endpoints)} {kinds}, {counted(messages, 'message')}"
    )


class _Settling:
    """Waits until the bridge has read a chunk, and for subscribers if the chunk created a topic."""

    def __init__(self, supervisor: Supervisor, *, is_fast: bool) -> None:
        self._supervisor = supervisor
        self._is_fast = is_fast
        self._known = 0

    async def settle(self) -> float:
        """Wait; return the waiting time in seconds, 0.0 if the bridge has no new endpoint."""
        await asyncio.sleep(0)
        loop = asyncio.get_running_loop()
        began_s = loop.time()
        # A thread searches for a type; the end of the capture would cancel the search.
        while True:
            boards = self._supervisor.boards()
            if not any(board.is_searching for board in boards):
                break
            await asyncio.sleep(SEARCH_POLL_S)
        known = sum(len(board.endpoints) for board in boards)
        if known <= self._known:
            self._known = known
            return 0.0
        self._known = known
        if self._is_fast:
            await asyncio.sleep(SUBSCRIBE_S)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LISTED_S):
                await self._supervisor.wait_for_subscribers()
        return loop.time() - began_s


@verb(
    "record",
    """
    rostether link record /dev/ttyACM0 problem.jsonl
    rostether link record "/dev/ttyUSB0?baud=115200" problem.jsonl
    rostether link record tcp://:11411 problem.jsonl --record-limit 10
    """,
    hints=ADDRESS_HINTS,
)
@click.argument("address", shell_complete=complete_ports)
@click.argument("file", type=FILE)
@record_limit_option
@listen_option
@graph_options(served=True, ros=False)
@msg_path_option
@click.pass_context
def link_record(
    ctx: click.Context,
    address: str,
    file: Path,
    record_limit_mb: float,
    listen: str | None,
    msg_paths: tuple[Path, ...],
    graph: GraphOptions,
) -> int:
    """Serve the board at ADDRESS, as `rostether serve` does, and record its line to FILE until Ctrl-C.

    The bridge itself records, so it opens the port only once. FILE must not exist. If the command is
    killed, only the last 0.2 s are missing. FILE contains every message between board and host.
    """
    code: int = ctx.invoke(
        serve,
        addresses=(address,),
        master=graph.master,
        record_line=file,
        record_limit_mb=record_limit_mb,
        listen=listen,
        allow=graph.allow,
        msg_paths=msg_paths,
    )
    return code
