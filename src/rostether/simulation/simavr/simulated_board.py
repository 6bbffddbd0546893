"""A simulated AVR board that runs real firmware in a separate process.

async with await SimulatedBoard.start(elf, board="uno", commands=["adc A0=2.5"]) as board:
    ...                                   # `board.address` is what `serve` opens
    await board.wait_for_pin("D13", True)
    assert await board.servo_angle("D9") == approx(90, abs=1)
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from pathlib import Path
from typing import Literal, Self

from rostether.errors import BoardError
from rostether.mechanisms.block_end import BlockClosable, task_beside
from rostether.mechanisms.loop_thread import in_own_loop
from rostether.simulation.simavr.board_events import BoardEvent
from rostether.simulation.simavr.compile import build_runner
from rostether.simulation.simavr.kinds import kind_of
from rostether.simulation.simavr.runner_process import RunnerProcess
from rostether.transports.address import SimulationPauses
from rostether.transports.pty_link import PtyLink

# A busy machine may simulate a board several times slower than it runs.
DEFAULT_TIMEOUT_S = 10.0
# Enough for ten seconds of a watched pin that toggles at 1 kHz; older events are dropped.
MAX_RECENT_EVENTS = 20_000
# Enough for a minute at 115200 baud.
MAX_SERIAL_BYTES = 1 << 20

LinkKind = Literal["pty", "tcp", "none"]
Matches = Callable[[BoardEvent], bool]


class SimulatedBoard(BlockClosable):
    """One board. Its methods raise BoardError for an invalid command, or if the board has ended.

    `address` is the link address of its serial line for `serve`, empty without a link. `recent` has its last
    events, `serial` the bytes that it sent while "serial" was watched.
    """

    commands = frozenset(("adc", "aref", "attitude", "fault", "pin", "power", "range", "reset", "wheels"))

    def __init__(self, process: RunnerProcess, ready: BoardEvent, link: PtyLink) -> None:
        self.kind: str = ready["board"]
        self.mcu: str = ready["mcu"]
        self.note: str = ready.values.get("note", "")
        self.recent: deque[BoardEvent] = deque([ready], maxlen=MAX_RECENT_EVENTS)
        self.serial = bytearray()
        self.pauses = SimulationPauses()
        self.address: str = ready["link"]
        self._process = process
        self._link = link
        self._listeners: list[Callable[[BoardEvent], None]] = []
        self._levels: dict[str, bool] = {}
        process.on_event = self._handle_event

    @classmethod
    async def start(  # noqa: PLR0913 - each is an independent setting of a board
        cls,
        program: Path,
        *,
        board: str = "uno",
        link: LinkKind = "pty",
        tcp_port: int = 0,
        link_path: Path | None = None,
        uart: int | None = None,
        realtime: bool = True,
        paused: bool = False,
        seed: int = 0,
        commands: Sequence[str] = (),
    ) -> Self:
        """Start an ELF or HEX file on a board.

        `link` is the host's end of its serial line: a pseudo-terminal, to which `link_path` becomes a link,
        a TCP port (`tcp_port`, 0 for a free one), or none. `uart` is the number of another UART for it.
        `commands` are executed before the first instruction. With `realtime=False` the board runs as fast as
        possible. With `paused` it runs only during a `run` command, which makes runs reproducible. `seed`
        sets the noise in RAM.

        Raises BoardError, ConfigError for an unknown board, TransportOpenError for a `link_path` in use.
        """
        kind = kind_of(board)
        terminal_link = PtyLink(link_path if link == "pty" else None)
        runner = await in_own_loop(build_runner)
        runner_link = f"tcp:{tcp_port}" if link == "tcp" else link
        arguments = ["--board", kind, "--link", runner_link, "--seed", str(seed)]
        arguments += [] if uart is None else ["--uart", str(uart)]
        arguments += [] if realtime else ["--fast"]
        arguments += ["--paused"] if paused else []
        process, events = await RunnerProcess.start(runner, [*arguments, "--", str(program), *commands])
        made = cls(process, events[0], terminal_link)
        for event in events[1:]:
            made._handle_event(event)
        try:
            terminal_link.place(made.address)
            wrong = next((event for event in events if event.name == "error"), None)
            if wrong is not None:
                raise BoardError(f"{wrong['line']}: {wrong['text']}")
        except BaseException:
            await made.close()
            raise
        return made

    @property
    def has_ended(self) -> bool:
        """Whether its process has ended."""
        return self._process.has_ended

    @property
    def has_ended_as_requested(self) -> bool:
        """Whether it has ended as requested: by `quit`, or after `for`."""
        return self._process.exit_code == 0

    async def send_command(self, line: str) -> None:
        """Send a command (docs/reference/simulated-boards.md), and wait until the board has executed it."""
        await self._process.send_command(line)

    async def ask(self, line: str, answer: str) -> BoardEvent:
        """Send a command whose answer is an event with the name `answer`; return the event."""
        answers: list[BoardEvent] = []
        with self._listening(lambda event: answers.append(event) if event.name == answer else None):
            await self.send_command(line)
        if not answers:
            raise BoardError(f"the simulated board did not answer {line!r} with {answer!r}")
        return answers[-1]

    async def wait_for(
        self, name: str, matches: Matches = lambda _event: True, *, timeout_s: float = DEFAULT_TIMEOUT_S
    ) -> BoardEvent:
        """Return the next event with this name that `matches` accepts.

        Raises BoardError if none occurs in time.
        """
        found: asyncio.Future[BoardEvent] = asyncio.get_running_loop().create_future()

        def check(event: BoardEvent) -> None:
            if event.name == name and not found.done() and matches(event):
                found.set_result(event)

        with self._listening(check):
            return await self._process.wait_before_end(found, f"event {name!r}", timeout_s)

    async def events(self) -> AsyncIterator[BoardEvent]:
        """Yield the events from now on until the board ends; a slow reader misses the oldest."""
        waiting: deque[BoardEvent] = deque(maxlen=MAX_RECENT_EVENTS)
        arrived = asyncio.Event()

        def keep(event: BoardEvent) -> None:
            waiting.append(event)
            arrived.set()

        ended = asyncio.ensure_future(self._process.wait_end())
        ended.add_done_callback(lambda _ended: arrived.set())
        try:
            with self._listening(keep):
                while not (ended.done() and not waiting):
                    await arrived.wait()
                    arrived.clear()
                    while waiting:
                        yield waiting.popleft()
                    if ended.done():
                        arrived.set()
        finally:
            ended.cancel()

    async def set_adc(self, pin: str, volts: float) -> None:
        """Set the voltage of an analog input, 0 to 5.5 V."""
        await self.send_command(f"adc {pin}={volts:.6f}")

    async def set_range(self, meters: float | None) -> None:
        """Set the distance of the obstacle in front of the HC-SR04; None removes it."""
        await self.send_command("range none" if meters is None else f"range {meters:.6f}")

    async def set_attitude(self, roll: float, pitch: float, yaw: float, *, over_s: float = 0.0) -> None:
        """Turn the board to angles in radians, immediately or within `over_s` of its time."""
        degrees = " ".join(f"{math.degrees(angle):.6f}" for angle in (roll, pitch, yaw))
        await self.send_command(f"attitude {degrees} in {over_s:.6f}")

    async def drive_pin(self, pin: str, level: bool | None) -> None:
        """Drive a pin from outside; None releases it."""
        await self.send_command(f"pin {pin}={'z' if level is None else int(level)}")

    async def pin_level(self, pin: str) -> bool:
        """Return a pin's level now."""
        return bool((await self.ask(f"pin {pin}", "pin"))["level"])

    async def pins(self) -> dict[str, str]:
        """Return all digital pins: "in1", "out0", or "pwm0.503" with its duty cycle."""
        return dict((await self.ask("pins", "pins")).values)

    async def wait_for_pin(self, pin: str, level: bool, *, timeout_s: float = DEFAULT_TIMEOUT_S) -> None:
        """Wait until a pin has a level, and watch the pin from then on. Raises BoardError."""
        await self.send_command(f"watch {pin}")
        if self._levels.get(pin) != level:
            await self.wait_for(
                "pin", lambda event: event["pin"] == pin and event["level"] == level, timeout_s=timeout_s
            )

    async def servo_pulse_us(self, pin: str, *, timeout_s: float = DEFAULT_TIMEOUT_S) -> float:
        """Return the length of the last servo pulse on a pin; wait for the first one."""
        if not self._has_pulsed(pin):
            await self.send_command(f"servo {pin}")
        if not self._has_pulsed(pin):
            first = await self.wait_for("servo", lambda event: event["pin"] == pin, timeout_s=timeout_s)
            return float(first["pulse_us"])
        return float((await self.ask(f"servo {pin}", "servo"))["pulse_us"])

    async def servo_angle(self, pin: str) -> float:
        """Return the angle of a servo on a pin in degrees from 0 to 180; wait for the first pulse."""
        return (await self.servo_pulse_us(pin) - 544.0) * 180.0 / (2400.0 - 544.0)

    async def set_faults(self, faults: str) -> None:
        """Set faults of the line, such as `flip=0.01,to:drop=0.001,seed=3`; `none` ends all of them.

        Rates that are not named do not change.
        """
        await self.send_command(f"fault {faults}")

    async def reset(self) -> None:
        """Press the reset button."""
        await self.send_command("reset")

    async def power(self, on: bool) -> None:
        """Switch the supply on or off."""
        await self.send_command(f"power {'on' if on else 'off'}")

    async def send(self, data: bytes) -> None:
        """Send bytes to the board's UART at line speed, in addition to the link's data."""
        await self.send_command(f"send {data.hex()}")

    async def run(self, duration: str | int, *, timeout_s: float = 60.0) -> None:
        """Run for a number of cycles or a time such as `20ms`, then pause; return after that.

        `timeout_s` is in real time. Raises BoardError.
        """
        async with task_beside(self.wait_for("stopped", timeout_s=timeout_s)) as found:
            await asyncio.sleep(0)
            await self.send_command(f"run {duration}")
            await found

    async def cycles(self) -> int:
        """Return how many cycles the board has run."""
        return int((await self.ask("cycles", "cycles"))["cycles"])

    async def memory(self, location: str, count: int | None = None) -> bytes:
        """Return RAM at a symbol of the program, or at an address such as `0x100`.

        The default of `count` is the size of the symbol, or one byte at an address.
        """
        answer = await self.ask(f"memory {location}{'' if count is None else f' {count}'}", "memory")
        return bytes.fromhex(answer["data"])

    async def free_stack_bytes(self) -> int:
        """Return the number of bytes between heap and stack that were never used since power-up.

        Raises BoardError for a program without symbols.
        """
        return int((await self.ask("stack", "stack"))["free_bytes"])

    async def guard(self, location: str) -> None:
        """Report each write to a symbol, or to a range such as `0x100..0x180`, as "guarded_write"."""
        await self.send_command(f"guard {location}")

    async def close(self) -> None:
        """End the board, and remove its files."""
        await self._process.close()
        self._link.remove()

    def _has_pulsed(self, pin: str) -> bool:
        return any(event.name == "servo" and event["pin"] == pin for event in self.recent)

    @contextlib.contextmanager
    def _listening(self, listener: Callable[[BoardEvent], None]) -> Iterator[None]:
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    def _handle_event(self, event: BoardEvent) -> None:
        # The list of all pins is large, and is requested many times a second.
        if event.name != "pins":
            self.recent.append(event)
        if event.name == "pin":
            self._levels[event["pin"]] = bool(event["level"])
        elif event.name == "serial":
            self.serial += bytes.fromhex(event["data"])
            del self.serial[:-MAX_SERIAL_BYTES]
        elif event.name == "behind":
            self.pauses.on_pause()
        for listener in tuple(self._listeners):
            listener(event)
