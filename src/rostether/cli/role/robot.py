"""A robot's nodes as roles: its state, its joints with sliders in the terminal, and tf for web pages."""

from __future__ import annotations

import asyncio
import shutil
import sys
from functools import partial

from rostether.cli.role.node import reporter, role
from rostether.cli.shell.keys import split_keys, typed_keys
from rostether.cli.shell.output import warn
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.tasks import run_until
from rostether.mechanisms.text import escape_line
from rostether.names.remap import Arguments
from rostether.robot.joint_sliders import JointSliders, SliderKey
from rostether.robot.joint_state_publisher import SLIDERS_TOPIC, publish_joint_states, read_joint_states
from rostether.robot.joint_states import JointStates
from rostether.robot.robot_state_publisher import publish_robot_state
from rostether.robot.tf_web_republisher import republish_for_web

NO_TERMINAL = (
    "no terminal for the sliders: they are in the dashboard, at Controls; or run in a terminal: "
    "rostether run joint_state_publisher_gui joint_state_publisher_gui __name:={}"
)


# Show the alternate screen without a cursor, and leave it.
_ENTER, _LEAVE = "\033[?1049h\033[?25l", "\033[?25h\033[?1049l"
_HOME, _CLEAR_LINE, _CLEAR_BELOW = "\033[H", "\033[K", "\033[J"

_KEYS = {
    b"\033[A": SliderKey.UP,
    b"\033OA": SliderKey.UP,
    b"k": SliderKey.UP,
    b"\033[B": SliderKey.DOWN,
    b"\033OB": SliderKey.DOWN,
    b"j": SliderKey.DOWN,
    b"\t": SliderKey.DOWN,
    b"\033[D": SliderKey.LESS,
    b"\033OD": SliderKey.LESS,
    b"h": SliderKey.LESS,
    b"-": SliderKey.LESS,
    b"\033[C": SliderKey.MORE,
    b"\033OC": SliderKey.MORE,
    b"l": SliderKey.MORE,
    b"+": SliderKey.MORE,
    b"\033[6~": SliderKey.MUCH_LESS,
    b"\033[5~": SliderKey.MUCH_MORE,
    b"0": SliderKey.CENTER_ONE,
    b"c": SliderKey.CENTER,
    b"r": SliderKey.RANDOMIZE,
}
_QUIT = b"q"


@role(
    "joint-state-publisher", "rostether role joint-state-publisher _rate:=50 _source_list:=[arm/joint_states]"
)
async def joint_state_publisher(graph: TypedGraph, _: Arguments) -> None:
    """Publish joint states: default positions, positions from other topics, and joints that mimic others.

    Parameters: rate (10), source_list, zeros, dependent_joints, delta, use_mimic_tags,
    use_smallest_joint_limits, publish_default_positions, publish_default_velocities, publish_default_efforts.
    """
    await publish_joint_states(graph, await read_joint_states(graph))


@role("joint-state-publisher-gui", "rostether role joint-state-publisher-gui")
async def joint_state_publisher_gui(graph: TypedGraph, _: Arguments) -> None:
    """Publish joint states set by sliders in the terminal: arrow keys move them, c centers, r randomizes."""
    # Windows has consoles, but no termios to read single keys.
    has_terminal = sys.platform != "win32" and sys.stdin.isatty() and sys.stdout.isatty()
    if not has_terminal:
        warn(NO_TERMINAL.format(graph.raw.node_name.rpartition("/")[2]))
    states = await read_joint_states(graph)
    if not has_terminal:
        await publish_joint_states(graph, states, more_sources=[SLIDERS_TOPIC])
        return
    screen = SliderScreen(states)
    await run_until(publish_joint_states(graph, states, screen.refresh), screen.run())


class SliderScreen:
    """The sliders of `states` in the terminal, and the keys that move them."""

    def __init__(self, states: JointStates) -> None:
        self._sliders = JointSliders(states)
        self._quit = asyncio.Event()

    async def run(self) -> None:
        """Show the sliders and handle keys until q is pressed or the terminal is closed."""
        with typed_keys(self._press):
            sys.stdout.write(_ENTER)
            try:
                self.refresh()
                await self._quit.wait()
            finally:
                sys.stdout.write(_LEAVE)
                sys.stdout.flush()

    def refresh(self) -> None:
        """Show the current sliders."""
        size = shutil.get_terminal_size()
        lines = [escape_line(line) + _CLEAR_LINE for line in self._sliders.lines(size.columns, size.lines)]
        sys.stdout.write(_HOME + "\r\n".join(lines) + _CLEAR_BELOW)
        sys.stdout.flush()

    def _press(self, typed: bytes) -> None:
        if not typed:
            self._quit.set()
        for key in split_keys(typed, _KEYS):
            if key == _QUIT:
                self._quit.set()
            elif key in _KEYS:
                self._sliders.press(_KEYS[key])
        self.refresh()


@role(
    "robot-state-publisher",
    "rostether role robot-state-publisher _publish_frequency:=30 joint_states:=arm/joint_states",
)
async def robot_state_publisher(graph: TypedGraph, _: Arguments) -> None:
    """Turn joint states into transforms, using the URDF in robot_description.

    Parameters: ~publish_frequency (50), ~use_tf_static (true), ~ignore_timestamp (false), tf_prefix.
    """
    await publish_robot_state(graph, partial(reporter(graph), Level.WARN))


@role("tf2-web-republisher", "rostether role tf2-web-republisher")
async def tf2_web_republisher(graph: TypedGraph, _: Arguments) -> None:
    """Send web pages the transforms that they request, like tf2_web_republisher.

    It serves the service republish_tfs and the action tf2_web_republisher, which ROSLIB.TFClient uses.
    """
    await republish_for_web(graph, partial(reporter(graph), Level.WARN))
