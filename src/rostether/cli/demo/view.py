"""The contents of the demo's screen: the board's state, the topics' values, and commands to try."""

from __future__ import annotations

import shutil
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from math import ceil, degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from rich.console import Console, ConsoleOptions, RenderResult
from rich.rule import Rule
from rich.table import Column, Table
from rich.text import Text

from rostether.graph.ports import Level
from rostether.mechanisms.text import counted
from rostether.pictures.sparkline import sparkline
from rostether.ros1.environment import DEFAULT_MASTER_PORT, parse_rpc_uri

if TYPE_CHECKING:
    from rostether.bridge.health.diagnostics import BoardView, EndpointView
    from rostether.serde.codec import Codec

# The window for rates: long enough for several messages of 1 Hz, short enough to follow a change.
RATE_WINDOW_S = 4.0
# The widest curve in a terminal; at four values a second, 20 seconds.
MAX_CURVE_VALUES = 80
_CACHES = {".cache", "Caches", "Cache"}
# The tallest terminal does not show more.
MAX_LINES = 100

KEYS = "Keys: l LED, arrows obstacle, q quit"
# The width of the terminal, in characters, from which a column is shown.
_TYPE_FROM_WIDTH = 100
_RATE_FROM_WIDTH = 50
_COUNT_FROM_WIDTH = 76
_NAME_WIDTH = 15
_VALUE_WIDTH = 13
_TYPE_WIDTH = 18
_RATE_WIDTH = 5
_COUNT_WIDTH = 8
_INDENT = "  "
_ARROWS = {"publisher": "->", "subscriber": "<-"}


class _Shown(Struct, frozen=True):
    """How values of a type are shown: as text and, with `number`, as a curve on a scale."""

    text: Callable[[Any], str]
    number: Callable[[Any], float] | None = None
    scale: tuple[float, float] | None = None


_SHOWN: Mapping[str, _Shown] = {
    "sensor_msgs/Range": _Shown(lambda message: f"{message.range:.2f} m", lambda message: message.range),
    "std_msgs/Bool": _Shown(
        lambda message: "on" if message.data else "off", lambda message: message.data, (0, 1)
    ),
    "std_msgs/UInt32": _Shown(lambda message: str(message.data)),
    "sensor_msgs/Imu": _Shown(
        lambda message: f"{degrees(message.angular_velocity.x):+.0f} deg/s",
        lambda message: message.angular_velocity.x,
    ),
    "tf/tfMessage": _Shown(
        lambda message: _position(message.transforms[0].transform.translation),
        lambda message: message.transforms[0].transform.translation.x,
    ),
}


def _position(translation: Any) -> str:
    return f"{translation.x:+.1f} {translation.y:+.1f} m"


class DemoFacts(Struct, frozen=True):
    """The texts that do not change while the demo runs."""

    title: str
    master_uri: str
    is_in_ros2: bool = False
    dashboard_url: str = ""
    has_keys: bool = False

    def next_steps(self) -> list[str]:
        """Return the commands for a second terminal."""
        command = command_to_type()
        is_usual = parse_rpc_uri(self.master_uri).port == DEFAULT_MASTER_PORT
        steps = [] if is_usual else [f"export ROS_MASTER_URI={self.master_uri.rstrip('/')}"]
        steps += [f"{command} topic echo /ultrasound", f"{command} topic pub -1 /toggle_led std_msgs/Empty"]
        return [*steps, f"{command} topic echo --ros2 zenoh /ultrasound"] if self.is_in_ros2 else steps


class RecentLines:
    """A bridge's `Reporter` that keeps the last lines for the screen's foot."""

    def __init__(self) -> None:
        self.lines: deque[str] = deque(maxlen=MAX_LINES)

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        """Keep a line, unless it is for debugging."""
        if level >= Level.INFO:
            self.lines.append(f"{node}: {text}" if node else text)

    def report_warning(self, level: Level, text: str) -> None:
        """Keep a line only from WARN upwards: the screen shows the content of INFO lines elsewhere."""
        if level >= Level.WARN:
            self.report(level, text)


class DemoView:
    """Collects the data that the demo shows; a payload is decoded only when it is drawn."""

    def __init__(self, boards: Callable[[], list[BoardView]], clock: Callable[[], float]) -> None:
        self.has_messages = False
        self.board: BoardView | None = None
        self._boards = boards
        self._clock = clock
        self._last: dict[str, tuple[Codec, bytes]] = {}
        self._curves: dict[str, deque[float]] = {}
        self._history: dict[str, deque[tuple[float, int]]] = {}

    def add_messages(self, topic: str, codec: Codec, payloads: Sequence[bytes]) -> None:
        """Add messages that arrived through the graph."""
        self.has_messages = True
        self._last[topic] = (codec, payloads[-1])

    def update(self) -> None:
        """Store the current state of the board."""
        self.board = next(iter(self._boards()), None)
        now_s = self._clock()
        for endpoint in self.board.endpoints if self.board is not None else ():
            history = self._history.setdefault(_key(endpoint), deque())
            history.append((now_s, endpoint.message_count))
            while now_s - history[0][0] > RATE_WINDOW_S and len(history) > 2:
                history.popleft()
            number = _SHOWN[endpoint.type].number if endpoint.type in _SHOWN else None
            message = self._message(endpoint)
            if number is not None and message is not None:
                curve = self._curves.setdefault(endpoint.name, deque(maxlen=MAX_CURVE_VALUES))
                curve.append(number(message))

    def line(self) -> str:
        """Return everything in one line, for logs and pipes."""
        if self.board is None:
            return "link: waiting for the board"
        topics = [
            f"{endpoint.name} {self.rate_hz(endpoint):.1f} Hz{f' ({value})' if value else ''}"
            for endpoint in self.board.endpoints
            if endpoint.role == "publisher"
            for value in [self.value(endpoint)]
        ]
        return "; ".join(
            [
                *topics,
                f"{counted(self.board.received_frames, 'frame')}, {self.board.discarded_frames} discarded",
            ]
        )

    def rate_hz(self, endpoint: EndpointView) -> float:
        """Return the rate of an endpoint's messages."""
        history = self._history.get(_key(endpoint), deque())
        # From the first arrival to the last: a fixed window would miscount by one message at 1 Hz.
        arrivals = [now for before, now in pairwise(history) if now[1] != before[1]]
        samples = arrivals if len(arrivals) > 1 else history
        if len(samples) < 2 or samples[-1][0] == samples[0][0]:
            return 0.0
        return (samples[-1][1] - samples[0][1]) / (samples[-1][0] - samples[0][0])

    def value(self, endpoint: EndpointView) -> str:
        """Return the last value of a topic, empty before the first."""
        message = self._message(endpoint)
        return "" if message is None else _SHOWN[endpoint.type].text(message)

    def curve(self, endpoint: EndpointView, width: int) -> str:
        """Return the last values of a topic as a curve of at most `width` characters."""
        values = self._curves.get(endpoint.name) if endpoint.role == "publisher" else None
        if not values or width < 1:
            return ""
        return sparkline(list(values)[-width:], _SHOWN[endpoint.type].scale)

    def _message(self, endpoint: EndpointView) -> Any:
        last = self._last.get(f"/{endpoint.name.lstrip('/')}")
        if last is None or endpoint.role != "publisher" or endpoint.type not in _SHOWN:
            return None
        codec, payload = last
        return codec.decode(payload)


def command_to_type() -> str:
    """Return the command for another terminal: `rostether` if it is on PATH there, else its path."""
    found = shutil.which("rostether")
    if found is None:
        return sys.argv[0]
    # uvx and pipx run add an environment from their cache only to this process's PATH.
    return found if _CACHES.intersection(Path(sys.prefix).parts) else "rostether"


def _key(endpoint: EndpointView) -> str:
    return f"{endpoint.role} {endpoint.name}"


class DemoScreen:
    """Draws a view that fits the terminal."""

    def __init__(self, facts: DemoFacts, view: DemoView, log: Sequence[str]) -> None:
        self._facts = facts
        self._view = view
        self._log = log

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Yield the lines, for rich."""
        width = options.max_width
        board = self._view.board
        endpoints = board.endpoints if board is not None else ()
        foot = list(self._foot())
        # The title, the table's head, the link's line, and the empty line above the foot.
        height = len(endpoints) + 4 + sum(ceil(len(line) / width) or 1 for line in foot)
        # The cursor needs the last line of the terminal.
        room = max(0, console.size.height - 1 - height)
        yield Rule(f"[bold]{self._facts.title}")
        yield self._table(endpoints, width)
        yield Text(_link(board, width), no_wrap=True, overflow="ellipsis")
        for line in list(self._log)[-room:] if room else ():
            yield Text(line, style="dim", no_wrap=True, overflow="ellipsis")
        yield ""
        for line in foot:
            # Long commands are continued at the left edge, so that they can be copied.
            yield Text(line, overflow="fold")

    def _foot(self) -> Sequence[str]:
        facts = self._facts
        return [
            f"{KEYS}, Ctrl-C stop" if facts.has_keys else "Press Ctrl-C to stop",
            *((f"Dashboard: {facts.dashboard_url}",) if facts.dashboard_url else ()),
            "In a second terminal:",
            *(f"{_INDENT}{step}" for step in facts.next_steps()),
        ]

    def _table(self, endpoints: Sequence[EndpointView], width: int) -> Table:
        columns = [Column("topic", width=_NAME_WIDTH, no_wrap=True)]
        if has_type := width >= _TYPE_FROM_WIDTH:
            columns.append(Column("type", width=_TYPE_WIDTH, no_wrap=True, style="cyan"))
        if has_rate := width >= _RATE_FROM_WIDTH:
            columns.append(Column("Hz", width=_RATE_WIDTH, justify="right"))
        if has_count := width >= _COUNT_FROM_WIDTH:
            columns.append(Column("messages", width=_COUNT_WIDTH, justify="right"))
        columns.append(Column("value", width=_VALUE_WIDTH, no_wrap=True, style="green"))
        columns.append(Column("", ratio=1, no_wrap=True, style="green", overflow="crop"))
        # Two spaces between columns.
        room = width - sum(column.width or 0 for column in columns) - 2 * (len(columns) - 1)
        table = Table(*columns, expand=True, box=None, pad_edge=False, padding=(0, 2, 0, 0), show_edge=False)
        for endpoint in endpoints:
            is_topic = endpoint.role in ("publisher", "subscriber")
            cells = [f"{_ARROWS.get(endpoint.role, '  ')} {endpoint.name}"]
            cells += [endpoint.type] if has_type else []
            cells += [f"{self._view.rate_hz(endpoint):.1f}" if is_topic else ""] if has_rate else []
            cells += [str(endpoint.message_count) if is_topic else ""] if has_count else []
            cells.append(self._view.value(endpoint) if is_topic else "service")
            table.add_row(*cells, self._view.curve(endpoint, room))
        return table


def _link(board: BoardView | None, width: int) -> str:
    """Return the state of the link, the more important facts first, as many as fit."""
    if board is None or not board.is_connected:
        return "link: waiting for the board"
    facts = [
        f"link: {'negotiated' if board.is_settled else 'negotiating'}",
        counted(board.received_frames, "frame"),
        f"{board.discarded_frames} damaged",
        counted(board.reset_count, "reset"),
        f"{board.received_bytes / 1000:.0f} kB in",
        f"{board.sent_bytes / 1000:.1f} kB out",
        board.peer,
    ]
    while len(facts) > 1 and len(", ".join(facts)) > width:
        facts.pop()
    return ", ".join(facts)
