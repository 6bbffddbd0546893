from __future__ import annotations

import pytest
from msgspec.structs import replace

from rostether.platform.command_frame import CommandFrame, Flags, decode_frame
from rostether.platform.command_link import (
    CommandReceiver,
    CommandSender,
    ReceiverSettings,
    SenderSettings,
)

KEY = b"0123456789abcdef"
KIND = b"\x75\x28\xcb\x4c"
TO_ROBOT = SenderSettings(3, to_groups=False, kind=KIND, key=KEY)


@pytest.fixture
def robot() -> CommandReceiver:
    return CommandReceiver(ReceiverSettings(3, groups=0b10, kind=KIND, key=KEY))


def test_a_command_is_repeated_until_it_stops(robot: CommandReceiver) -> None:
    sender = CommandSender(TO_ROBOT, 1_000)
    first = sender.command(b"go", 0.0)
    assert [robot.receive(each, 0.0) is not None for each in first] == [True, True, True]
    assert (robot.is_moving, sender.due_s) == (True, 0.05)
    assert len(sender.command(b"go", 0.02)) == 1
    # Commands that change continuously need no repetitions.
    assert len(sender.command(b"left", 0.03)) == 1
    assert len(sender.command(b"turn", 0.06)) == 3
    (again,) = sender.repeat(0.11)
    frame = robot.receive(again, 0.11)
    assert frame is not None
    assert (frame.payload, frame.ttl_ms) == (b"turn", 300)
    frames, now_s = sender.stop(0.12), 0.12
    while sender.due_s is not None:
        assert sender.due_s - now_s == pytest.approx(0.02)
        now_s = sender.due_s
        frames += sender.repeat(now_s)
    assert len(frames) == 10
    for each in frames:
        robot.receive(each, now_s)
    assert not robot.is_moving
    assert sender.repeat(9.0) == []


def test_a_robot_stops_when_its_sender_is_silent(robot: CommandReceiver) -> None:
    sender = CommandSender(replace(TO_ROBOT, ttl_ms=500), 1_000)
    robot.receive(sender.command(b"go", 0.0)[0], 10.0)
    assert robot.deadline_s == 10.5
    assert not robot.expire(10.49)
    assert robot.expire(10.5)
    assert not robot.expire(10.6)
    assert not robot.is_moving


def test_old_recorded_and_forged_commands_have_no_effect(robot: CommandReceiver) -> None:
    sender = CommandSender(TO_ROBOT, 1_000)
    recorded = sender.command(b"go", 0.0)
    robot.receive(recorded[1], 0.0)
    for each in recorded[:2]:
        assert robot.receive(each, 0.0) is None
        assert robot.last_refusal == ""
    assert robot.receive(CommandSender(replace(TO_ROBOT, key=bytes(16)), 2_000).stop(0.0)[0], 0.0) is None
    assert "a different key" in robot.last_refusal
    # After a later sender, all frames of an earlier one are refused, even stops.
    robot.receive(CommandSender(TO_ROBOT, 2_000).stop(0.1)[0], 0.1)
    assert robot.receive(sender.stop(0.1)[0], 99.0) is None
    assert "started before the last one" in robot.last_refusal


def test_one_sender_at_a_time(robot: CommandReceiver) -> None:
    first, second = CommandSender(TO_ROBOT, 1_000), CommandSender(TO_ROBOT, 2_000)
    robot.receive(first.command(b"go", 0.0)[0], 0.0)
    assert robot.receive(second.command(b"go", 0.0)[0], 0.2) is None
    assert robot.last_refusal == "another sender commands this robot"
    assert robot.is_moving
    # The first sender is silent for its time to live; a replay of refused frames moves nothing.
    recorded = second.command(b"go", 0.2)[0]
    assert robot.receive(recorded, 0.21) is None
    assert robot.receive(recorded, 0.3) is None
    assert robot.last_refusal == ""
    assert robot.receive(second.repeat(0.3)[0], 0.3) is not None
    # After a release, another sender is accepted immediately.
    robot.receive(second.release(), 0.31)
    assert not robot.is_moving
    assert robot.receive(CommandSender(TO_ROBOT, 3_000).command(b"go", 0.0)[0], 0.32) is not None


def test_a_stop_of_a_later_sender_is_obeyed_at_once(robot: CommandReceiver) -> None:
    first = CommandSender(TO_ROBOT, 1_000)
    robot.receive(first.command(b"go", 0.0)[0], 0.0)
    robot.receive(CommandSender(TO_ROBOT, 2_000).stop(0.0)[0], 0.1)
    assert not robot.is_moving
    assert robot.receive(first.repeat(0.1)[0], 0.15) is None


def test_a_sender_that_ends_does_not_stop_robots_of_another(robot: CommandReceiver) -> None:
    first, second = CommandSender(TO_ROBOT, 1_000), CommandSender(TO_ROBOT, 2_000)
    robot.receive(first.command(b"go", 0.0)[0], 0.0)
    for each in (second.query(), *second.command(b"go", 0.1), *second.halt(0.1), second.release()):
        assert robot.receive(each, 0.1) is None
    assert (robot.is_moving, robot.holder_epoch_us) == (True, 1_000)
    robot.receive(first.halt(0.2)[0], 0.2)
    assert (robot.is_moving, robot.holder_epoch_us) == (False, 1_000)
    robot.receive(first.release(), 0.2)
    assert robot.holder_epoch_us is None


@pytest.mark.parametrize(
    ("target", "to_groups", "is_meant"),
    [(3, False, True), (2, False, False), (0b10, True, True), (0b101, True, False), (0xFFFFFFFF, True, True)],
)
def test_robots_and_groups(robot: CommandReceiver, target: int, to_groups: bool, is_meant: bool) -> None:
    settings = replace(TO_ROBOT, target=target, to_groups=to_groups)
    assert (robot.receive(CommandSender(settings, 1).command(b"", 0.0)[0], 0.0) is not None) == is_meant
    assert robot.last_refusal == ""


def test_a_command_of_another_type(robot: CommandReceiver) -> None:
    other = CommandSender(replace(TO_ROBOT, kind=b"\1\2\3\4"), 1)
    assert robot.receive(other.command(b"", 0.0)[0], 0.0) is None
    assert "01020304" in robot.last_refusal
    assert robot.receive(other.stop(0.0)[0], 0.0) is not None
    assert robot.receive(other.release(), 0.0) is not None
    assert robot.deadline_s is None


def test_the_sequence_ends_with_a_new_epoch() -> None:
    sender = CommandSender(TO_ROBOT, 1_000)
    sender.sequence = 0xFFFF_FFFE
    frames = [decode_frame(each, KEY) for each in sender.command(b"go", 0.0)]
    assert [(each.epoch_us, each.sequence) for each in frames] == [(1000, 0xFFFFFFFF), (1001, 1), (1001, 2)]


def test_a_frame_that_is_not_armed_moves_nothing(robot: CommandReceiver) -> None:
    robot.receive(CommandFrame(3, 1, 1, Flags(0), kind=KIND).encode(KEY), 0.0)
    assert not robot.is_moving
