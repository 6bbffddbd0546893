from __future__ import annotations

import struct

import pytest

from rostether.nodes.joystick import Joystick, PublishTiming


def event(kind: int, number: int, value: int) -> bytes:
    return struct.pack("<IhBB", 1234, value, kind, number)


def test_buttons_and_axes() -> None:
    joystick = Joystick(deadzone=0.0)
    assert joystick.feed(event(0x81, 2, 0) + event(0x82, 1, -32767)) is PublishTiming.SOON
    assert (joystick.buttons, joystick.axes) == ([0, 0, 0], [0.0, 0.0])
    assert joystick.feed(event(1, 2, 1)) is PublishTiming.NOW
    assert joystick.buttons == [0, 0, 1]
    assert joystick.feed(event(2, 1, 32767)) is PublishTiming.SOON
    assert joystick.axes == [0.0, -1.0]
    assert joystick.feed(event(2, 0, -16384)) is PublishTiming.SOON
    assert joystick.axes[0] == pytest.approx(0.50002, abs=1e-5)
    assert joystick.feed(event(2, 0, 0) + event(1, 0, 1)) is PublishTiming.NOW


def test_events_may_arrive_in_pieces() -> None:
    joystick = Joystick()
    whole = event(1, 0, 1)
    assert joystick.feed(whole[:5]) is PublishTiming.NEVER
    assert joystick.feed(whole[5:]) is PublishTiming.NOW
    assert joystick.buttons == [1]


def test_the_middle_of_an_axis_counts_as_zero() -> None:
    joystick = Joystick(deadzone=0.5)
    for value, expected in ((16383, 0.0), (-16383, 0.0), (32767, -1.0), (-32767, 1.0), (24575, -0.5)):
        joystick.feed(event(2, 0, value))
        assert joystick.axes[0] == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(("given", "kept"), [(-1.0, 0.0), (0.95, 0.9), (3276.7, 0.1), (0.2, 0.2)])
def test_deadzones_are_limited(given: float, kept: float) -> None:
    assert Joystick(given).deadzone == pytest.approx(kept)


def test_an_axis_may_begin_where_it_was() -> None:
    joystick = Joystick(0.0, default_trig_val=True)
    joystick.feed(event(0x82, 0, -32767))
    assert joystick.axes == [1.0]


def test_sticky_buttons_toggle() -> None:
    joystick = Joystick(sticky_buttons=True)
    seen = []
    for value in (1, 0, 1, 1, 0, 1):
        joystick.feed(event(1, 0, value))
        seen.append(joystick.buttons[0])
    assert seen == [1, 1, 0, 0, 0, 1]


def test_other_events_are_ignored() -> None:
    joystick = Joystick()
    assert joystick.feed(event(4, 9, 1)) is PublishTiming.NEVER
    assert (joystick.axes, joystick.buttons) == ([], [])
