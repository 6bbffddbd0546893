"""`rostether xbee simulate`: a simulated radio network, with a serial port for the host."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from dataclasses import dataclass
from pathlib import Path

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.board.qemu import find_program
from rostether.cli.shell.option_group import PATH, NumberRange, option, option_group
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.cli.shell.verbs import verb
from rostether.mechanisms.text import counted
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from rostether.simulation.xbee.air import AirConditions
from rostether.simulation.xbee.counting_board import CountingBoard
from rostether.simulation.xbee.network import XbeeNetwork
from rostether.simulation.xbee.radio import SimulatedRadio
from rostether.simulation.xbee.registers import MODELS
from rostether.transports.address import PtyAddress
from rostether.transports.memory import memory_pair
from rostether.transports.opening import open_transport
from rostether.transports.peers import MAX_PEERS
from rostether.transports.pty import open_pty

_PROBABILITY = NumberRange(0.0, 1.0)
_KINDS = ("series1", "series3", "digimesh")


@dataclass(frozen=True, slots=True)
class SimulationOptions:
    """The settings of a simulation."""

    boards: int = option(
        "--boards",
        "How many boards have a radio.",
        type=click.IntRange(1, MAX_PEERS),
        show_default=True,
        default=1,
    )
    link_path: Path | None = option(
        "--link", "Create the serial port of the host's radio at PATH.", type=PATH
    )
    fresh_path: Path | None = option(
        "--fresh", "Create the serial port of a radio in its factory settings at PATH.", type=PATH
    )
    kind: str = option(
        "--kind", "The kind of all radios.", type=click.Choice(_KINDS), show_default=True, default=_KINDS[0]
    )
    loss: float = option(
        "--loss", "The share of lost transmissions, e.g. 0.05 (default: 0).", type=_PROBABILITY, default=0.0
    )
    repeat: float = option(
        "--repeat", "The share of packets that arrive twice (default: 0).", type=_PROBABILITY, default=0.0
    )
    delay_ms: float = option(
        "--delay MS",
        "The additional delay of each packet, in ms (default: 0).",
        type=NumberRange(0.0, 10_000.0),
        default=0.0,
    )
    rssi_dbm: int = option(
        "--signal DBM",
        "The signal strength, in dBm.",
        type=click.IntRange(-120, -1),
        show_default=True,
        default=-60,
    )
    rate_hz: float = option(
        "--rate HZ",
        "How often each board publishes.",
        type=NumberRange(0.1, 100.0),
        show_default=True,
        default=5.0,
    )
    seed: int = option(
        "--seed", "The seed of the losses (default: 0).", type=click.IntRange(0, 2**32 - 1), default=0
    )


@verb(
    "simulate",
    """
    rostether xbee simulate --boards 8 --loss 0.05 --link ./xbee
    rostether xbee simulate --boards 3 --kind digimesh --delay 20 --link ./xbee
    rostether xbee simulate Blink.ino --boards 2 --link ./xbee
    rostether xbee simulate --fresh ./radio
    """,
    is_service=True,
)
@click.argument("sketch", type=PATH, required=False)
@option_group("options", SimulationOptions)
@msg_path_option
async def xbee_simulate(sketch: Path | None, options: SimulationOptions, msg_paths: tuple[Path, ...]) -> None:
    """Run a simulated XBee network: a radio for the host, and boards with a radio each.

    Board 1 publishes board_1/count (std_msgs/UInt32) and subscribes to board_1/led (std_msgs/Bool). With
    SKETCH, the boards are simulated Unos that run it. The radios answer AT commands and lose packets like
    real ones.
    """
    if options.link_path is None and options.fresh_path is None:
        raise click.UsageError("give --link, the serial port for `rostether serve`, or --fresh")
    if sketch is not None and options.link_path is None:
        raise click.UsageError("SKETCH is for the boards of a network; give --link, its serial port")
    conditions = AirConditions(options.loss, options.repeat, options.delay_ms / 1e3, options.rssi_dbm)
    network = XbeeNetwork(conditions, model=MODELS[options.kind], seed=options.seed)
    boards: list[CountingBoard] = []
    async with AsyncExitStack() as stack:
        stack.callback(network.close)
        if options.fresh_path is not None:
            network.add_fresh(open_pty(PtyAddress(str(options.fresh_path))))
            write_line(f"A radio in its factory settings is at {options.fresh_path}")
        if options.link_path is not None:
            coordinator = network.add_coordinator(open_pty(PtyAddress(str(options.link_path))))
            if sketch is None:
                boards = await _add_counting(network, coordinator, options, stack)
            else:
                await _add_sketches(network, coordinator, sketch, options, msg_paths, stack)
            write_line(
                f"{counted(options.boards, 'board')} on {options.kind} radios, {options.loss:.0%} loss; "
                f"connect: rostether serve xbee:{options.link_path}"
            )
        try:
            await asyncio.get_running_loop().create_future()
        finally:
            _show_totals(network, boards)


async def _add_counting(
    network: XbeeNetwork, coordinator: SimulatedRadio, options: SimulationOptions, stack: AsyncExitStack
) -> list[CountingBoard]:
    boards = []
    for number in range(1, options.boards + 1):
        port, radio_port = memory_pair()
        network.add_board(radio_port, coordinator, short_address=number)
        boards.append(CountingBoard(f"board_{number}", port, rate_hz=options.rate_hz))
        await stack.enter_async_context(boards[-1])
    return boards


async def _add_sketches(
    network: XbeeNetwork,
    coordinator: SimulatedRadio,
    sketch: Path,
    options: SimulationOptions,
    msg_paths: tuple[Path, ...],
    stack: AsyncExitStack,
) -> None:
    with reported_when_long(warn, f"preparing {counted(options.boards, 'simulated board')} for {sketch}"):
        program = await find_program(sketch, "uno", msg_paths)
        for number in range(1, options.boards + 1):
            board = await stack.enter_async_context(await SimulatedBoard.start(program, seed=number))
            network.add_board(await open_transport(board.address), coordinator, short_address=number)


def _show_totals(network: XbeeNetwork, boards: list[CountingBoard]) -> None:
    for board in boards:
        write_line(
            f"{board.name}: published {board.published}, LED switched {counted(board.led_changes, 'time')}"
        )
    counts = network.air.counts
    write_line(
        f"The radios sent {counted(counts.packets, 'packet')} in "
        f"{counted(counts.transmissions, 'transmission')}; "
        f"{counts.lost_packets} were lost, {counts.repeated_packets} arrived twice"
    )
