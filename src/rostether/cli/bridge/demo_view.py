"""The output of `rostether demo`: a live table of the board's topics, or plain lines without a terminal."""

from __future__ import annotations

import shutil
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from math import atan2, degrees
from typing import TYPE_CHECKING, Any

from rostether.graph.ports import Level
from rostether.ros1.environment import DEFAULT_MASTER_PORT, parse_rpc_uri

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rostether.bridge.health.diagnostics import BoardView, EndpointView
    from rostether.serde.codec import Codec

# The window for rates: long enough to be steady, short enough to follow a change.
RATE_WINDOW_S = 2.0
SHOWN_LINES = 4

NEXT_STEPS = """In a second terminal:
  {us} topic echo /ultrasound
  {us} topic pub -1 /toggle_led std_msgs/Empty"""

NEXT_STEP_ROS2 = """
  {us} topic echo --ros2 zenoh /ultrasound"""

SUMMARIES: Mapping[str, Callable[[Any], str]] = {
    "sensor_msgs/Range": lambda message: f"{message.range:.2f} m",
    "std_msgs/Bool": lambda message: "on" if message.data else "off",
    "std_msgs/UInt32": lambda message: str(message.data),
    "sensor_msgs/Imu": lambda message: f"{degrees(message.angular_velocity.z):+.0f} deg/s",
    "tf/tfMessage": lambda message: _pose(message.transforms[0].transform),
}


def _pose(transform: Any) -> str:
    yaw = 2 * atan2(transform.rotation.z, transform.rotation.w)
    return f"{transform.translation.x:+.1f} {transform.translation.y:+.1f} m {degrees(yaw):+.0f} deg"


class RecentLines:
    """A bridge's `Reporter` that keeps the last lines for the table's foot."""

    def __init__(self) -> None:
        self.lines: deque[str] = deque(maxlen=SHOWN_LINES)

    def line(self, level: Level, text: str, *, node: str = "") -> None:
        """Keep one line."""
        if level >= Level.INFO:
            self.lines.append(f"{node}: {text}" if node else text)


class DemoView:
    """Collects what the demo shows; a payload is decoded only when it is drawn."""

    def __init__(
        self,
        boards: Callable[[], list[BoardView]],
        clock: Callable[[], float],
        recent: RecentLines,
        master_uri: str,
        *,
        is_in_ros2: bool = False,
        dashboard_url: str = "",
    ) -> None:
        self.has_flowed = False
        self._boards = boards
        self._clock = clock
        self._recent = recent
        self._master_uri = master_uri
        self._is_in_ros2 = is_in_ros2
        self._dashboard_url = dashboard_url
        self._board: BoardView | None = None
        self._last: dict[str, tuple[Codec, bytes]] = {}
        self._history: dict[str, deque[tuple[float, int]]] = {}

    def saw(self, topic: str, codec: Codec, payloads: Sequence[bytes]) -> None:
        """Add messages that arrived through the graph."""
        self.has_flowed = True
        self._last[topic] = (codec, payloads[-1])

    def update(self) -> None:
        """Store the current state of the board."""
        self._board = next(iter(self._boards()), None)
        if self._board is None:
            return
        now_s = self._clock()
        for endpoint in self._board.endpoints:
            history = self._history.setdefault(_key(endpoint), deque())
            history.append((now_s, endpoint.message_count))
            while now_s - history[0][0] > RATE_WINDOW_S and len(history) > 2:
                history.popleft()

    def line(self) -> str:
        """Return everything in one line, for logs and pipes."""
        if self._board is None:
            return self._health()
        topics = [
            f"{endpoint.name} {self._rate_hz(endpoint):.1f} Hz{f' ({value})' if value else ''}"
            for endpoint in self._board.endpoints
            if endpoint.role == "publisher"
            for value in [self._value(endpoint)]
        ]
        return "; ".join(
            [*topics, f"{self._board.received_frames} frames, {self._board.discarded_frames} discarded"]
        )

    def render(self) -> RenderableType:
        """Return the table, the link's health, the last lines and what to type next."""
        from rich.console import Group
        from rich.panel import Panel
        from rich.table import Column, Table
        from rich.text import Text

        table = Table(
            Column("topic or service", no_wrap=True),
            Column("type", no_wrap=True, style="cyan"),
            Column("Hz", justify="right"),
            Column("messages", justify="right"),
            Column("last value", ratio=1, no_wrap=True, style="green"),
            expand=True,
            box=None,
        )
        for endpoint in self._board.endpoints if self._board is not None else ():
            is_topic = endpoint.role in ("publisher", "subscriber")
            table.add_row(
                f"{'<-' if endpoint.role == 'subscriber' else '->'} {endpoint.name}"
                if is_topic
                else f"   {endpoint.name}",
                endpoint.type,
                f"{self._rate_hz(endpoint):.1f}" if is_topic else "",
                str(endpoint.message_count) if is_topic else "service",
                self._value(endpoint),
            )
        return Panel(
            Group(
                table,
                "",
                self._health(),
                Text("\n".join(self._recent.lines), style="dim"),
                "",
                *((f"Dashboard: {self._dashboard_url}",) if self._dashboard_url else ()),
                (NEXT_STEPS + (NEXT_STEP_ROS2 if self._is_in_ros2 else "")).format(us=self._us()),
            ),
            title=f"a simulated board on the ROS graph at {self._master_uri}"
            + (" and on ROS 2" if self._is_in_ros2 else ""),
            subtitle="press Ctrl-C to stop",
        )

    def _us(self) -> str:
        """Return how to run us in a second terminal: with the graph's address, unless it is the usual one."""
        uri = self._master_uri
        is_usual = parse_rpc_uri(uri).port == DEFAULT_MASTER_PORT
        return our_command() if is_usual else f"ROS_MASTER_URI={uri.rstrip('/')} {our_command()}"

    def _health(self) -> str:
        board = self._board
        if board is None or not board.is_connected:
            return "link: waiting for the board"
        return (
            f"link: {board.peer}, {'negotiated' if board.is_settled else 'negotiating'}, "
            f"protocol {board.protocol_version}, {board.received_frames} frames,\n"
            f"      {board.discarded_frames} damaged, {board.reset_count} resets, "
            f"{board.received_bytes / 1000:.0f} kB in, {board.sent_bytes / 1000:.1f} kB out"
        )

    def _rate_hz(self, endpoint: EndpointView) -> float:
        history = self._history.get(_key(endpoint), deque())
        if len(history) < 2 or history[-1][0] == history[0][0]:
            return 0.0
        return (history[-1][1] - history[0][1]) / (history[-1][0] - history[0][0])

    def _value(self, endpoint: EndpointView) -> str:
        last = self._last.get(f"/{endpoint.name.lstrip('/')}")
        if last is None or endpoint.role != "publisher":
            return ""
        codec, payload = last
        return SUMMARIES[endpoint.type](codec.decode(payload))


def our_command() -> str:
    """Return what to type to run us again: our name where PATH has it, else the path we were run by."""
    return "rostether" if shutil.which("rostether") else sys.argv[0]


def _key(endpoint: EndpointView) -> str:
    return f"{endpoint.role} {endpoint.name}"
