"""Joint sliders in a terminal: keys in, lines out, and the terminal as it was afterwards."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import sys
import termios
import tty
from typing import TYPE_CHECKING

from rostether.mechanisms.text import escape_line
from rostether.robot.joint_sliders import JointSliders, SliderKey

if TYPE_CHECKING:
    from rostether.robot.joint_states import JointStates

_READ_BYTES = 1024  # a held key repeats thirty times a second, three bytes each
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
_LONGEST = max(map(len, _KEYS))


class SliderScreen:
    """Shows the sliders of `states` until q is pressed."""

    def __init__(self, states: JointStates) -> None:
        self._sliders = JointSliders(states)
        self._quit = asyncio.Event()

    async def run(self) -> None:
        """Show and obey until q is pressed or cancelled."""
        stdin = sys.stdin.fileno()
        before = termios.tcgetattr(stdin)
        loop = asyncio.get_running_loop()
        tty.setcbreak(stdin)
        sys.stdout.write(_ENTER)
        loop.add_reader(stdin, self._read, stdin)
        try:
            self.refresh()
            await self._quit.wait()
        finally:
            loop.remove_reader(stdin)
            termios.tcsetattr(stdin, termios.TCSADRAIN, before)
            sys.stdout.write(_LEAVE)
            sys.stdout.flush()

    def refresh(self) -> None:
        """Show the current sliders."""
        size = shutil.get_terminal_size()
        lines = [escape_line(line) + _CLEAR_LINE for line in self._sliders.lines(size.columns, size.lines)]
        sys.stdout.write(_HOME + "\r\n".join(lines) + _CLEAR_BELOW)
        sys.stdout.flush()

    def _read(self, stdin: int) -> None:
        typed = b""
        with contextlib.suppress(BlockingIOError, InterruptedError):
            typed = os.read(stdin, _READ_BYTES)
            if not typed:
                self._quit.set()
        for key in split_keys(typed):
            if key == _QUIT:
                self._quit.set()
            elif key in _KEYS:
                self._sliders.press(_KEYS[key])
        self.refresh()


def split_keys(typed: bytes) -> list[bytes]:
    """Return the keys in the bytes from a terminal; each byte that is not part of a known key is separate."""
    keys, at = [], 0
    while at < len(typed):
        length = next(
            (each for each in range(min(_LONGEST, len(typed) - at), 1, -1) if typed[at : at + each] in _KEYS),
            1,
        )
        keys.append(typed[at : at + length])
        at += length
    return keys
