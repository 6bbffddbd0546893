"""Joint sliders in a terminal: reads keys, draws lines, and restores the terminal at the end."""

from __future__ import annotations

import asyncio
import shutil
import sys
from typing import TYPE_CHECKING

from rostether.cli.shell.keys import split_keys, typed_keys
from rostether.mechanisms.text import escape_line
from rostether.robot.joint_sliders import JointSliders, SliderKey

if TYPE_CHECKING:
    from rostether.robot.joint_states import JointStates

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
