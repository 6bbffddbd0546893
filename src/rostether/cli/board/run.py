"""`rostether board run`: a sketch on a simulated board, with commands on stdin and events on stdout."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.board.console import EventPrinter, handling_commands, show_start
from rostether.cli.board.opencr import OPENCR, run_opencr
from rostether.cli.board.qemu import find_program, run_in_qemu
from rostether.cli.shell.option_group import PATH, flag, option, option_group
from rostether.cli.shell.output import json_option, warn
from rostether.cli.shell.slow_notice import reported_when_long
from rostether.cli.shell.verbs import verb
from rostether.errors import BoardError
from rostether.simulation.qemu import MACHINES
from rostether.simulation.simavr.kinds import kind_of
from rostether.simulation.simavr.simulated_board import SimulatedBoard

# `board run` and `firmware sim` still accept them.
OLD_OPTIONS = {"--for": "--duration"}
# Options that are commands of the simulator under the same name.
_REPEATED = ("adc", "pin", "servo", "watch", "guard")
_SINGLE = ("hcsr04", "range", "attitude", "fault", "network", "w5100", "wheels")


@dataclass(frozen=True, slots=True)
class BoardOptions:
    """The options of `board run`."""

    board: str = option(
        "--board",
        "uno, nano, promini, mega, leonardo, micro; lm3s6965evb, netduinoplus2 in qemu; opencr.",
        show_default=True,
        default="uno",
    )
    link_path: Path | None = option("--link", "Create a link to the board's serial port at PATH.", type=PATH)
    tcp_port: int | None = option(
        "--tcp PORT", "Offer the board's serial port as this TCP port.", type=click.IntRange(0, 65535)
    )
    uart: int | None = option(
        "--uart", "The UART to connect (default: 0; leonardo, micro: 1).", type=click.IntRange(0, 3)
    )
    adc: tuple[str, ...] = option("--adc A0=VOLTS", "Set the voltage of an analog input.", multiple=True)
    pin: tuple[str, ...] = option("--pin D7=0|1", "Set the level of a digital pin.", multiple=True)
    range: str | None = option(
        "--range", "Connect an HC-SR04 with an obstacle at this distance.", metavar="METERS|none"
    )
    hcsr04: str | None = option("--hcsr04", "The pins of the HC-SR04.", metavar="trig=D6,echo=D5")
    attitude: str | None = option(
        "--attitude", "The attitude of the board and its MPU-9150, in degrees.", metavar='"ROLL PITCH YAW"'
    )
    watch: tuple[str, ...] = option(
        "--watch", "Print changes of a pin, or the serial output.", multiple=True, metavar="PIN|serial"
    )
    servo: tuple[str, ...] = option("--servo PIN", "Print the angle of a servo on a pin.", multiple=True)
    fault: str | None = option(
        "--fault", "Simulate a bad serial line: flip, drop, delay.", metavar="flip=0.01,seed=3"
    )
    network: str | None = option(
        "--network HOST:PORT", "Redirect all TCP connections of the sketch to this address."
    )
    w5100: str | None = option(
        "--w5100",
        "The Ethernet shield's loopback address, and the number of multicast datagrams until it stalls.",
        metavar="address=127.0.0.2,stall_after=500",
    )
    wheels: str | None = option(
        "--wheels",
        "The pins for PWM and direction of two motors; the command `wheels` shows the odometry.",
        metavar="left=D3/D8,right=D9/D7",
    )
    autoreset: bool = flag("--autoreset", "Reset the board whenever the port is opened, as USB boards do.")
    guard: tuple[str, ...] = option(
        "--guard SYMBOL", "Print writes to a variable of the program.", multiple=True
    )
    seed: int = option(
        "--seed",
        "The seed of the random RAM contents at power-up (default: 0).",
        type=click.IntRange(0, 2**32 - 1),
        default=0,
    )
    is_fast: bool = flag("--fast", "Run as fast as possible instead of in real time.")
    duration: str | None = option(
        "--duration TIME", 'Stop after this simulated time, e.g. 2, 2s, 20ms or "160000 cycles".'
    )

    @property
    def commands(self) -> tuple[str, ...]:
        """The inputs and devices of the board at its start, as commands of the simulator."""
        commands = [f"{word} {value}" for word in _REPEATED for value in getattr(self, word)]
        commands += [f"{word} {value}" for word in _SINGLE if (value := getattr(self, word)) is not None]
        return (*commands, "autoreset on") if self.autoreset else tuple(commands)

    @property
    def has_avr_options(self) -> bool:
        """Whether there are options that only simulated AVR boards have, besides `commands`."""
        return any((self.duration, self.uart, self.tcp_port, self.is_fast, self.seed))


@verb(
    "board-run",
    """
    rostether board run blink.ino --watch D13
    rostether board run Ultrasound.ino --link /tmp/board --range 0.5
    rostether board run imu.elf --board mega --attitude "10 0 90" --json
    rostether board run test.elf --fast --duration 2s
    """,
    is_service=True,
    old_options=OLD_OPTIONS,
)
@click.argument("program", type=PATH)
@option_group("start", BoardOptions)
@msg_path_option
@json_option
async def board_run(program: Path, start: BoardOptions, msg_paths: tuple[Path, ...], as_json: bool) -> None:
    """Run a sketch, or an ELF or HEX file, on a simulated Arduino board.

    Its serial port is a pseudo-terminal, whose path is printed: `rostether serve` accepts it. While it runs,
    lines of standard input are commands with the names of the options (adc A0=2.5, range 0.5, pin D7=1,
    fault none) and more (reset, power off, memory SYMBOL); see the reference of commands and events.
    """
    if start.link_path is not None and start.tcp_port is not None:
        raise click.UsageError("give --link or --tcp, not both")
    if start.board in MACHINES:
        has_others = bool(start.commands) or start.has_avr_options
        await run_in_qemu(
            program, start.board, start.link_path, has_other_options=has_others, as_json=as_json
        )
        return
    if start.board == OPENCR:
        has_others = start.has_avr_options
        await run_opencr(
            program, start.commands, start.link_path, msg_paths, has_other_options=has_others, as_json=as_json
        )
        return
    kind_of(start.board)
    link: Literal["pty", "tcp"] = "pty" if start.tcp_port is None else "tcp"
    ending = [f"for {_simulator_time(start.duration)}"] if start.duration else []
    preparing = f"preparing a simulated {start.board} for {program}; this takes longer the first time"
    with reported_when_long(warn, preparing):
        found = await find_program(program, start.board, msg_paths)
        board = await SimulatedBoard.start(
            found,
            board=start.board,
            link=link,
            tcp_port=start.tcp_port or 0,
            link_path=start.link_path,
            uart=start.uart,
            realtime=not start.is_fast,
            seed=start.seed,
            commands=[*start.commands, *ending],
        )

    async def execute(line: str) -> None:
        try:
            await board.send_command(line)
        except BoardError:
            if not board.has_ended:
                raise

    async with board:
        if not as_json:
            note = f" ({board.note})" if board.note else ""
            title = f"{board.kind} ({board.mcu})"
            show_start(title, board.kind, program, board.address, start.link_path, note)
        async with handling_commands(execute):
            printer = EventPrinter(as_json=as_json)
            for event in list(board.recent)[0 if as_json else 1 :]:
                printer.show(event)
            async for event in board.events():
                printer.show(event)
            printer.flush()
        if not board.has_ended_as_requested:
            raise BoardError("the simulated board ended unexpectedly; please report it")


def _simulator_time(text: str) -> str:
    """Return a duration as the simulator reads it, where a number without a unit is in cycles."""
    if text.endswith(" cycles"):
        return text.removesuffix(" cycles")
    return f"{text}s" if text.replace(".", "", 1).isdecimal() else text
