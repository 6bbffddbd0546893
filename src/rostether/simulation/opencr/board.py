"""A simulated OpenCR: a sketch compiled as a Linux program, with a robot at its servo bus, pins and sensors.

async with await OpenCrBoard.start(program) as board:
    ...                              # `board.address` is what `serve` opens
    board.set_pin("BDPIN_PUSH_SW_1", high=True)
    board.base.x_m                   # where the robot is
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import tty
from collections import deque
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, Self

from rostether.errors import BoardError, ConfigError
from rostether.mechanisms.block_end import BlockClosable
from rostether.mechanisms.program import wait_or_kill
from rostether.simulation.opencr.drive_base import DriveBase
from rostether.simulation.opencr.pins import pin_name, pin_number
from rostether.simulation.simavr.board_events import BoardEvent
from rostether.transports.pty_link import PtyLink

# The last line of the program's output is the reason for its end.
_MAX_OUTPUT_BYTES = 4096
# An unfinished line must not fill the memory.
_MAX_UNFINISHED_BYTES = 16 * 1024
# More tones than any melody of a sketch.
_MAX_TONES = 64
BLUETOOTH = "bluetooth"
# The program ends within milliseconds; after this time, it is killed.
END_LIMIT_S = 2.0

# The board measures its supply through a divider of 5.7, other pins directly; both with 10 bits at 3.3 V.
BATTERY_FULL_SCALE_V = 3.3 * 5.7
PIN_FULL_SCALE_V = 3.3
# The sound travels there and back, at 342 m/s.
_ECHO_US_PER_M = 2e6 / 342
_BATTERY_PIN = pin_number("BDPIN_BAT_PWR_ADC")
# Just below the largest voltage that the board can measure.
_MAX_BATTERY_V = 18.0


class Tone(NamedTuple):
    """A tone of the buzzer; 0 hertz is silence, a length of 0 ms lasts until the next tone."""

    hertz: int
    length_ms: int


class OpenCrBoard(BlockClosable):
    """One board on a robot. It ends with `close`, and with this process.

    `address`: the link address of its USB port for `serve`. `base`: the robot. `inputs`: the levels of driven
    inputs by number; `pins`: those of outputs. `tones`: the last tones, oldest first. `on_event` gets the
    tones, and the events that `watched` adds: numbers of outputs, and BLUETOOTH for the lines that the sketch
    prints to SerialBT2. `exit_message`: the last line of the program's error output, after its end.
    """

    def __init__(
        self,
        process: asyncio.subprocess.Process,
        base: DriveBase,
        lines: dict[str, socket.socket],
        terminal: str,
        link: PtyLink,
    ) -> None:
        self.address = terminal
        self.base = base
        self.inputs: dict[int, bool] = {}
        self.pins: dict[int, bool] = {}
        self.tones: deque[Tone] = deque(maxlen=_MAX_TONES)
        self.watched: set[int | str] = set()
        self.on_event: Callable[[BoardEvent], None] | None = None
        self.exit_message = ""
        self._process = process
        self._lines = lines
        self._link = link
        self._unfinished = b""
        self._unfinished_text = b""
        self._sent_motion_line = ""
        self._loop = asyncio.get_running_loop()
        self._started_s = self._loop.time()
        self._read_lines("OPENCR_DXL", self._handle_servo_requests)
        self._read_lines("OPENCR_PINS", self._receive_pins)
        self._read_lines("OPENCR_BLUETOOTH", self._receive_text)
        self._ending = self._loop.create_task(self._wait())

    @classmethod
    async def start(
        cls, program: Path, *, link_path: Path | None = None, clock: Callable[[], float] | None = None
    ) -> Self:
        """Start a program of `build_for_linux`; `link_path` becomes a link to its USB port.

        The robot has a full battery and does not move. Raises BoardError if the program does not start,
        TransportOpenError for a `link_path` in use.
        """
        link = PtyLink(link_path)
        base = DriveBase(clock if clock is not None else asyncio.get_running_loop().time)
        with contextlib.ExitStack() as child_ends, contextlib.ExitStack() as at_error:
            master, slave = os.openpty()
            child_ends.callback(os.close, master)
            child_ends.callback(os.close, slave)
            tty.setraw(slave)
            terminal = os.ttyname(slave)
            descriptors = {"OPENCR_USB": master}
            own_ends: dict[str, socket.socket] = {}
            for name in ("OPENCR_DXL", "OPENCR_PINS", "OPENCR_BLUETOOTH"):
                own, other = socket.socketpair()
                own_ends[name] = at_error.enter_context(own)
                child_ends.enter_context(other)
                own.setblocking(False)
                descriptors[name] = other.fileno()
            # These lines wait for the program when it starts.
            _send(own_ends["OPENCR_PINS"], _battery_line(12.0) + _motion_line(base))
            try:
                process = await asyncio.create_subprocess_exec(
                    str(program),
                    stdin=asyncio.subprocess.DEVNULL,
                    stdout=asyncio.subprocess.DEVNULL,
                    stderr=asyncio.subprocess.PIPE,
                    pass_fds=tuple(descriptors.values()),
                    env={**os.environ, **{name: str(fd) for name, fd in descriptors.items()}},
                    # Ctrl-C ends this process; the program ends when its pins are closed.
                    start_new_session=True,
                )
            except OSError as error:
                raise BoardError(f"cannot run {program}: {error.strerror}; build the sketch again") from error
            link.place(terminal)
            at_error.pop_all()
        return cls(process, base, own_ends, terminal, link)

    @property
    def has_ended(self) -> bool:
        """Whether the program has ended."""
        return self._ending.done()

    @property
    def time_s(self) -> float:
        """How long the program has been running, in seconds."""
        return self._loop.time() - self._started_s

    def event(self, name: str, **values: object) -> BoardEvent:
        """Return an event with the present time."""
        return BoardEvent(name, self.time_s, MappingProxyType(values))

    def set_pin(self, name: str, *, high: bool) -> None:
        """Drive an input. Raises ConfigError for an unknown pin."""
        number = pin_number(name)
        self.inputs[number] = high
        self._send_to_sketch(f"pin {number} {high:d}\n")

    def set_voltage(self, name: str, volts: float) -> None:
        """Apply 0 to 3.3 V to an analog input. Raises ConfigError for an unknown pin or another voltage."""
        if not 0 <= volts <= PIN_FULL_SCALE_V:
            raise ConfigError(
                f"{volts:g} V is not possible at {name}; its inputs accept 0 to {PIN_FULL_SCALE_V:g} V"
            )
        self._send_to_sketch(f"adc {pin_number(name)} {round(volts / PIN_FULL_SCALE_V * 1023)}\n")

    def set_battery(self, volts: float) -> None:
        """Change the supply of the board and the servos. Raises ConfigError beyond 0 to 18 V."""
        if not 0 <= volts <= _MAX_BATTERY_V:
            raise ConfigError(
                f"the board cannot measure a battery of {volts:g} V; give 0 to {_MAX_BATTERY_V:g} V"
            )
        self._send_to_sketch(_battery_line(volts))
        for servo in self.base.servos.values():
            servo.set_voltage(volts)

    def set_range(self, meters: float | None) -> None:
        """Set the distance of the obstacle in front of the sonar in meters; None removes it."""
        self._send_to_sketch(f"sonar {0 if meters is None else round(meters * _ECHO_US_PER_M)}\n")

    def send_remote_buttons(self, buttons: int) -> None:
        """Send a packet of the remote control RC-100. `buttons`: the bits up 1, down 2, left 4, right 8."""
        low, high = buttons & 0xFF, buttons >> 8 & 0xFF
        _send(self._lines["OPENCR_BLUETOOTH"], bytes((0xFF, 0x55, low, low ^ 0xFF, high, high ^ 0xFF)))

    async def wait_end(self) -> None:
        """Wait until the program has ended."""
        await asyncio.shield(self._ending)

    async def close(self) -> None:
        """End the program, and wait for its end. Idempotent."""
        self._link.remove()
        for line in self._lines.values():
            if line.fileno() >= 0:
                self._loop.remove_reader(line)
                line.close()
        # The program ends when its pins are closed; one that hangs does not.
        await wait_or_kill(self._process, END_LIMIT_S)
        await self._ending

    def _read_lines(self, name: str, receive: Callable[[bytes], None]) -> None:
        line = self._lines[name]

        def read() -> None:
            try:
                data = line.recv(4096)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if data:
                receive(data)
            else:
                self._loop.remove_reader(line)

        self._loop.add_reader(line, read)

    def _handle_servo_requests(self, data: bytes) -> None:
        answer = self.base.receive(data)
        if answer:
            _send(self._lines["OPENCR_DXL"], answer)
        motion_line = _motion_line(self.base)
        if motion_line != self._sent_motion_line:
            self._sent_motion_line = motion_line
            self._send_to_sketch(motion_line)

    def _receive_pins(self, data: bytes) -> None:
        *lines, self._unfinished = (self._unfinished + data)[-_MAX_UNFINISHED_BYTES:].split(b"\n")
        for line in lines:
            match line.split():
                case [b"pin", number, level]:
                    pin, is_high = int(number), level != b"0"
                    self.pins[pin] = is_high
                    if pin in self.watched:
                        self._report("pin", pin=pin_name(pin), level=int(is_high))
                case [b"tone", hertz, length_ms]:
                    tone = Tone(int(hertz), int(length_ms))
                    self.tones.append(tone)
                    self._report("tone", hertz=tone.hertz, length_ms=tone.length_ms)

    def _receive_text(self, data: bytes) -> None:
        *lines, self._unfinished_text = (self._unfinished_text + data)[-_MAX_UNFINISHED_BYTES:].split(b"\n")
        if BLUETOOTH in self.watched:
            for line in lines:
                self._report(BLUETOOTH, text=line.decode(errors="replace").rstrip("\r"))

    def _report(self, name: str, **values: object) -> None:
        if self.on_event is not None:
            self.on_event(self.event(name, **values))

    def _send_to_sketch(self, text: str) -> None:
        _send(self._lines["OPENCR_PINS"], text)

    async def _wait(self) -> None:
        stderr = self._process.stderr
        assert stderr is not None
        output = b""
        while chunk := await stderr.read(4096):
            output = (output + chunk)[-_MAX_OUTPUT_BYTES:]
        await self._process.wait()
        self.exit_message = output.decode(errors="replace").strip().rpartition("\n")[2]


def _send(line: socket.socket, data: str | bytes) -> None:
    # If the program does not read, the bytes are lost, as on the board.
    with contextlib.suppress(OSError):
        line.send(data.encode() if isinstance(data, str) else data)


def _battery_line(volts: float) -> str:
    return f"adc {_BATTERY_PIN} {min(1023, round(volts / BATTERY_FULL_SCALE_V * 1023))}\n"


def _motion_line(base: DriveBase) -> str:
    return "motion " + " ".join(f"{part:.9g}" for vector in base.imu_values() for part in vector) + "\n"
