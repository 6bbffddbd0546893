"""Sliders for joints, without terminal I/O: the selected slider, the keys, and the lines to show."""

from __future__ import annotations

import random
from collections.abc import Callable
from enum import Enum, auto

from rostether.robot.joint_states import FreeJoint, JointStates

# Key presses from one end of a slider to the other; Page Up and Page Down are `_FAST` times as fast.
STEPS = 200
_FAST = 20

# Columns: a shorter bar is useless, and a longer one moves away from its number.
_MIN_BAR = 10
_MAX_BAR = 60


class SliderKey(Enum):
    """The actions of the keys."""

    UP = auto()
    DOWN = auto()
    LESS = auto()
    MORE = auto()
    MUCH_LESS = auto()
    MUCH_MORE = auto()
    CENTER_ONE = auto()
    CENTER = auto()
    RANDOMIZE = auto()


_STEPS_OF = {
    SliderKey.LESS: -1,
    SliderKey.MORE: 1,
    SliderKey.MUCH_LESS: -_FAST,
    SliderKey.MUCH_MORE: _FAST,
}


class JointSliders:
    """One slider for each free joint of `states`, in the order of the robot's description."""

    def __init__(self, states: JointStates, choose: Callable[[float, float], float] = random.uniform) -> None:
        self._states = states
        self._names = list(states.free)
        self._chosen = 0
        self._choose = choose

    def press(self, key: SliderKey) -> None:
        """Handle a key."""
        if not self._names:
            return
        name = self._names[self._chosen]
        joint = self._states.free[name]
        if key is SliderKey.UP:
            self._chosen = (self._chosen - 1) % len(self._names)
        elif key is SliderKey.DOWN:
            self._chosen = (self._chosen + 1) % len(self._names)
        elif key is SliderKey.CENTER:
            self._states.center()
        elif key is SliderKey.CENTER_ONE:
            joint.position = joint.zero
        elif key is SliderKey.RANDOMIZE:
            for each_name, each in self._states.free.items():
                self._states.set_position(each_name, self._choose(each.lower, each.upper))
        else:
            step = _STEPS_OF[key] * (joint.upper - joint.lower) / STEPS
            self._states.set_position(name, _position(joint) + step)

    def lines(self, width: int, height: int) -> list[str]:
        """Return the lines to show in a terminal of `width` columns and `height` rows."""
        if not self._names:
            return ["The robot has no joint that can be set."]
        name_width = min(max(map(len, self._names)), max(width - _MIN_BAR - 16, 8))
        bar_width = max(_MIN_BAR, min(width - name_width - 16, _MAX_BAR))
        rows = max(height - 2, 1)
        first = min(max(self._chosen - rows + 1, 0), max(len(self._names) - rows, 0))
        lines = [
            self._line(index, name_width, bar_width)
            for index in range(first, min(first + rows, len(self._names)))
        ]
        hint = "↑↓ choose  ←→ move  PgUp/PgDn faster  0 zero  c center all  r randomize  q quit"
        return [line[:width] for line in [*lines, "", hint]]

    def _line(self, index: int, name_width: int, bar_width: int) -> str:
        name = self._names[index]
        joint = self._states.free[name]
        position, span = _position(joint), joint.upper - joint.lower
        part = (position - joint.lower) / span if span > 0 else 0.5
        knob = round(min(max(part, 0.0), 1.0) * (bar_width - 1))
        bar = "─" * knob + "●" + "─" * (bar_width - 1 - knob)
        mark = ">" if index == self._chosen else " "
        return f"{mark} {name[:name_width]:<{name_width}} {position:9.4f}  {bar}"


def _position(joint: FreeJoint) -> float:
    return joint.zero if joint.position is None else joint.position
