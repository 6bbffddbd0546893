"""The built-in joint_state_publisher and joint_state_publisher_gui, with sliders in the terminal."""

from __future__ import annotations

import asyncio
import shutil
import sys
from typing import TYPE_CHECKING

import click

from rostether.cli.role.node import RoleVerb, node_arguments, node_words, role_node
from rostether.cli.shell.keys import split_keys, typed_keys
from rostether.cli.shell.output import warn
from rostether.cli.shell.running import run
from rostether.graph.ports import Level
from rostether.mechanisms.text import escape_line
from rostether.names.remap import Arguments
from rostether.robot.joint_sliders import JointSliders, SliderKey

if TYPE_CHECKING:
    from rostether.robot.joint_states import JointStates


GUI_NAME = "joint_state_publisher_gui"

NO_TERMINAL = (
    "no terminal for the sliders: they are in the dashboard, at Controls; or run in a terminal: "
    "rostether run joint_state_publisher_gui joint_state_publisher_gui __name:={}"
)


_ENTER, _LEAVE = "\033[?1049h\033[?25l", "\033[?25h\033[?1049l"  # the alternate screen, without a cursor
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


STATE_NODE = "robot_state_publisher"


@click.command(
    "joint-state-publisher",
    cls=RoleVerb,
    examples="rostether role joint-state-publisher _rate:=50 _source_list:=[arm/joint_states]",
)
@node_words
def joint_state_publisher(arguments: tuple[str, ...]) -> None:
    """Publish joint states: default positions, positions from other topics, and joints that mimic others.

    Parameters: rate (10), source_list, zeros, dependent_joints, delta, use_mimic_tags,
    use_smallest_joint_limits, publish_default_positions, publish_default_velocities, publish_default_efforts.
    """
    run(
        _publish_joints(node_arguments(arguments), "joint_state_publisher", has_sliders=False),
        is_service=True,
    )


@click.command("joint-state-publisher-gui", cls=RoleVerb, examples="rostether role joint-state-publisher-gui")
@node_words
def joint_state_publisher_gui(arguments: tuple[str, ...]) -> None:
    """Publish joint states set by sliders in the terminal: arrow keys move them, c centers, r randomizes."""
    # Windows has consoles, but no termios to read single keys.
    has_terminal = sys.platform != "win32" and sys.stdin.isatty() and sys.stdout.isatty()
    given = node_arguments(arguments)
    if not has_terminal:
        warn(NO_TERMINAL.format(given.special.get("__name", GUI_NAME)))
    run(_publish_joints(given, GUI_NAME, has_sliders=has_terminal), is_service=True)


async def _publish_joints(arguments: Arguments, node_name: str, *, has_sliders: bool) -> None:
    from rostether.robot.joint_state_publisher import SLIDERS_TOPIC, publish_joint_states, read_joint_states

    async with role_node(arguments, node_name) as graph:
        states = await read_joint_states(graph)
        if not has_sliders:
            sliders = [SLIDERS_TOPIC] if node_name == GUI_NAME else []
            await publish_joint_states(graph, states, more_sources=sliders)
            return

        screen = SliderScreen(states)
        publishing = asyncio.create_task(publish_joint_states(graph, states, screen.refresh))
        sliding = asyncio.create_task(screen.run())
        try:
            done, _ = await asyncio.wait({publishing, sliding}, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in (publishing, sliding):
                task.cancel()
            await asyncio.gather(publishing, sliding, return_exceptions=True)


class SliderScreen:
    """Shows the sliders of `states` until q is pressed."""

    def __init__(self, states: JointStates) -> None:
        self._sliders = JointSliders(states)
        self._quit = asyncio.Event()

    async def run(self) -> None:
        """Show the sliders and handle keys until q is pressed or cancelled."""
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


@click.command(
    "robot-state-publisher",
    cls=RoleVerb,
    examples="rostether role robot-state-publisher _publish_frequency:=30 joint_states:=arm/joint_states",
)
@node_words
def robot_state_publisher(arguments: tuple[str, ...]) -> None:
    """Turn joint states into transforms, using the URDF in robot_description.

    Parameters: ~publish_frequency (50), ~use_tf_static (true), ~ignore_timestamp (false), tf_prefix.
    """
    run(_publish(node_arguments(arguments)), is_service=True)


async def _publish(arguments: Arguments) -> None:
    from rostether.robot.robot_state_publisher import publish_robot_state

    async with role_node(arguments, STATE_NODE) as graph:

        def report(problem: str) -> None:
            graph.log(Level.WARN, problem)
            warn(f"[WARN] {problem}")

        await publish_robot_state(graph, report)


@click.command("tf2-web-republisher", cls=RoleVerb, examples="rostether role tf2-web-republisher")
@node_words
def tf2_web_republisher(arguments: tuple[str, ...]) -> None:
    """Send web pages the transforms they ask for, like tf2_web_republisher.

    It serves the service republish_tfs and the action tf2_web_republisher, which ROSLIB.TFClient uses.
    """
    run(_serve(node_arguments(arguments)), is_service=True)


async def _serve(arguments: Arguments) -> None:
    from rostether.robot.tf_web_republisher import NODE_NAME, report_to, republish_for_web

    async with role_node(arguments, NODE_NAME) as graph:
        await republish_for_web(graph, report_to(graph))
