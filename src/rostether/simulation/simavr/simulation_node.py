"""The node of a simulated board: its pins as a topic, and commands that change its environment.

`~state` is JSON for web pages; `~command` accepts commands of docs/reference/simulated-boards.md.
"""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import aclosing
from typing import Any, Protocol

from rostether.errors import BoardError
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.tasks import cancel_all
from rostether.mechanisms.text import escape_line
from rostether.simulation.simavr.board_events import BoardEvent

STRING = "std_msgs/String"
ODOMETRY = "nav_msgs/Odometry"

# These commands have a value for each pin.
_BY_PIN = ("adc", "pin")

# Longer than any command; the shown errors have the same limit.
MAX_COMMAND_CHARS = 200
# Fast enough to look live; without a subscriber, the board is not queried.
PERIOD_S = 0.1


class NodeBoard(Protocol):
    """A board as the node uses it. Its methods raise BoardError.

    `commands` are those that every node on the graph may send; its other commands read memory, open
    connections or end the board.
    """

    kind: str
    mcu: str
    commands: frozenset[str]

    @property
    def has_ended(self) -> bool:
        """Whether the simulation has ended."""

    async def pins(self) -> dict[str, str]:
        """Return the states of its pins by name, such as `in0`, `out1` and `pwm0.5`."""

    async def send_command(self, line: str) -> None:
        """Execute one of its commands."""

    async def ask(self, line: str, answer: str) -> BoardEvent:
        """Execute a command whose answer is an event."""

    def events(self) -> AsyncIterator[BoardEvent]:
        """Yield the board's events until it has ended."""


class SimulationNode:
    """The node of one board; `commands` are those with which the board was started.

    `max_volts` is the limit of analog inputs. `has_servo_pins`: whether each output may have a servo.
    `on_command` gets each command from the graph that the board has executed.
    """

    def __init__(
        self,
        board: NodeBoard,
        graph: TypedGraph,
        commands: Iterable[str] = (),
        *,
        max_volts: float = 5.0,
        has_servo_pins: bool = True,
        on_command: Callable[[str], None] | None = None,
    ) -> None:
        self._board = board
        self._max_volts = max_volts
        self._has_servo_pins = has_servo_pins
        self._on_command = on_command
        self._graph = graph
        self._last_values: dict[str, Any] = {}
        self._servos: dict[str, float] = {}
        self._watched: set[str] = set()
        self._error = ""
        self._has_wheels = asyncio.Event()
        for line in commands:
            self._record_command(line)

    async def run(self) -> None:
        """Publish the state and execute commands until the board ends or the task is canceled.

        Raises GraphError.
        """
        works = (self._publish(), self._publish_odometry(), self._execute_commands(), self._follow_servos())
        parts = [asyncio.create_task(each) for each in works]
        try:
            done, _ = await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
            for part in done:
                part.result()
        except BoardError:
            # The board has ended; the command that started it reports this.
            return
        finally:
            await cancel_all(*parts)

    async def _publish(self) -> None:
        publisher = await self._graph.publisher("~state", STRING, latch=True)
        shown = ""
        while not self._board.has_ended:
            if publisher.subscriber_count:
                pins = await self._board.pins()
                if self._has_servo_pins:
                    await self._watch_servos(pins)
                state = self._state(pins)
                if state != shown:
                    shown = state
                    publisher.publish(data=state)
            await asyncio.sleep(PERIOD_S)

    def _state(self, pins: dict[str, str]) -> str:
        return json.dumps(
            {
                "board": self._board.kind,
                "mcu": self._board.mcu,
                "pins": pins,
                "servos": self._servos,
                "values": self._last_values,
                "commands": sorted(self._board.commands),
                "max_volts": self._max_volts,
                "error": self._error,
            }
        )

    async def _publish_odometry(self) -> None:
        """Publish the robot's odometry once the wheels have pins."""
        await self._has_wheels.wait()
        publisher = await self._graph.publisher("~odom", ODOMETRY)
        while not self._board.has_ended:
            if publisher.subscriber_count:
                wheels = await self._board.ask("wheels", "wheels")
                half_rad = wheels["heading_rad"] / 2
                publisher.publish(
                    header={"stamp": "now", "frame_id": "odom"},
                    child_frame_id="base_link",
                    pose={
                        "pose": {
                            "position": {"x": wheels["x_m"], "y": wheels["y_m"]},
                            "orientation": {"z": math.sin(half_rad), "w": math.cos(half_rad)},
                        }
                    },
                    twist={
                        "twist": {
                            "linear": {"x": wheels["speed_m_s"]},
                            "angular": {"z": wheels["turn_rad_s"]},
                        }
                    },
                )
            await asyncio.sleep(PERIOD_S)

    async def _watch_servos(self, pins: dict[str, str]) -> None:
        """Watch the servo pulses of each output pin; other pins cannot have a servo."""
        for pin, state in pins.items():
            if state.startswith("in") or pin in self._watched:
                continue
            self._watched.add(pin)
            await self._board.send_command(f"servo {pin}")

    async def _follow_servos(self) -> None:
        async for event in self._board.events():
            if event.name == "servo":
                self._servos[event["pin"]] = round(float(event["angle_deg"]), 1)
            elif event.name == "reset":
                self._servos.clear()

    async def _execute_commands(self) -> None:
        async with aclosing(aiter(self._graph.messages("~command", STRING))) as messages:
            async for message in messages:
                try:
                    await self._execute_checked(message.data)
                    self._error = ""
                except BoardError as error:
                    self._error = escape_line(str(error), MAX_COMMAND_CHARS)

    async def _execute_checked(self, line: str) -> None:
        word = line.split(maxsplit=1)[0] if line.strip() else ""
        if word not in self._board.commands:
            raise BoardError(f"{word[:20]!r} is not one of {', '.join(sorted(self._board.commands))}")
        if len(line) > MAX_COMMAND_CHARS or not line.isprintable():
            raise BoardError(f"a command is one line of at most {MAX_COMMAND_CHARS} characters")
        await self.execute(line)
        if self._on_command is not None:
            self._on_command(line)

    async def execute(self, line: str) -> None:
        """Execute a command, and show it in the state. Raises BoardError."""
        await self._board.send_command(line)
        self._record_command(line)

    def _record_command(self, line: str) -> None:
        word, _, rest = line.strip().partition(" ")
        if word == "wheels":
            self._has_wheels.set()
        if word not in self._board.commands or word == "reset":
            return
        if word not in _BY_PIN:
            self._last_values[word] = rest.strip()
            return
        values = self._last_values.setdefault(word, {})
        for part in rest.split():
            pin, has_value, value = part.partition("=")
            if has_value:
                values[pin if pin[:1].isalpha() else f"D{pin}"] = value
