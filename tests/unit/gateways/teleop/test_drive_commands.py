from __future__ import annotations

import math
from typing import Any

import pytest

from rostether.errors import SerializationError
from rostether.gateways.teleop.drive_commands import DRIVE_TYPES, DriveCommands, DriveLimits
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore

LIMITS = DriveLimits(1.0, 2.0, 1.0, 2.0, 6.0, 2.0)
STORE = TypeStore(Registry())
TWIST = "geometry_msgs/Twist"


def twist(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Any:
    codec = STORE.codec(TWIST)
    return codec.decode(codec.encode({"linear": {"x": x, "y": y}, "angular": {"z": yaw}}))


def limited(commands: DriveCommands, now_s: float, message: Any) -> tuple[float, float, float]:
    commands.limit(message, now_s)
    return message.linear.x, message.linear.y, message.angular.z


@pytest.fixture
def commands() -> DriveCommands:
    return DriveCommands(TWIST, LIMITS)


def test_the_robot_speeds_up_within_its_limits(commands: DriveCommands) -> None:
    speeds = [limited(commands, step * 0.05, twist(5.0))[0] for step in range(15)]
    # The first command comes after a pause: 2 m/s each second, for 0.1 s.
    assert speeds == pytest.approx([min(0.2 + 0.1 * step, 1.0) for step in range(15)])


def test_a_vector_keeps_its_direction(commands: DriveCommands) -> None:
    for step in range(20):
        x, y, _ = limited(commands, step * 0.05, twist(3.0, 4.0))
    assert (x, y) == pytest.approx((0.6, 0.8))


def test_it_slows_down_and_stops_at_once(commands: DriveCommands) -> None:
    for step in range(20):
        limited(commands, step * 0.05, twist(1.0, yaw=2.0))
    assert limited(commands, 1.0, twist(0.3)) == (0.3, 0.0, 0.0)
    assert commands.limit(twist(), 1.0)


def test_a_reversal_goes_through_zero(commands: DriveCommands) -> None:
    for step in range(20):
        limited(commands, step * 0.05, twist(1.0))
    assert limited(commands, 1.0, twist(-1.0))[0] == pytest.approx(-0.1)


def test_a_stopped_clock_speeds_nothing_up(commands: DriveCommands) -> None:
    first = limited(commands, 1.0, twist(1.0))[0]
    assert limited(commands, 1.0, twist(1.0))[0] == first


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_a_number_is_refused(commands: DriveCommands, value: float) -> None:
    with pytest.raises(SerializationError, match="not NaN or infinity"):
        commands.limit(twist(value), 0.0)


def test_a_stop_after_it_starts_again(commands: DriveCommands) -> None:
    message = twist(1.0)
    commands.limit(message, 0.0)
    commands.stop(message)
    assert (message.linear.x, message.linear.y, message.angular.z) == (0.0, 0.0, 0.0)
    assert limited(commands, 1.0, twist(1.0))[0] == pytest.approx(0.2)


def test_other_commands_have_their_own_stop() -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("arduino_control/ArduinoControl", "float64 dir\nfloat64 speed\n")
    codec = TypeStore(registry).codec("arduino_control/ArduinoControl")
    commands = DriveCommands("arduino_control/ArduinoControl", LIMITS)
    message: Any = codec.decode(codec.encode({"dir": 45.0, "speed": 1.414}))
    assert not commands.limit(message, 0.0)
    assert (message.dir, message.speed) == (45.0, pytest.approx(0.2))
    commands.stop(message)
    assert (message.dir, message.speed) == (45.0, 0.0)


def test_a_stamped_command_keeps_its_header() -> None:
    codec = STORE.codec("geometry_msgs/TwistStamped")
    message: Any = codec.decode(
        codec.encode({"header": {"frame_id": "base"}, "twist": {"linear": {"x": 9.0}}})
    )
    DriveCommands("geometry_msgs/TwistStamped", LIMITS).limit(message, 0.0)
    assert (message.header.frame_id, message.twist.linear.x) == ("base", pytest.approx(0.2))


def test_limits_are_read_from_parameters() -> None:
    limits = DriveLimits.of({"max_linear": 2, "max_angular": "fast", "max_speed": True, "max_none": 1})
    assert limits == DriveLimits(max_linear=2.0)
    assert DriveLimits.of({"max_linear": -1.0}) == DriveLimits()


def test_every_type_is_known() -> None:
    for name in DRIVE_TYPES:
        DriveCommands(name, LIMITS)
