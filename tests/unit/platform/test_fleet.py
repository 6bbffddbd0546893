from __future__ import annotations

import asyncio
import socket
import time

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError, TransportError
from rostether.msgdef.registry import Registry
from rostether.platform import fleet
from rostether.platform.command_channel import CommandChannel
from rostether.platform.command_frame import NO_KEY, Flags, decode_frame
from rostether.platform.command_link import CommandSender, ReceiverSettings, SenderSettings
from rostether.platform.fleet import FleetSender, FleetSettings, has_stopped, silence_text
from rostether.platform.fleet_examination import examine
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress
from rostether.platform.status_frame import Refusal, RobotStatus
from unit.platform.datagrams import PlainReceiver, loopback_group, running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until

BOOL = "std_msgs/Bool"
KIND = bytes.fromhex(Registry().message_type(BOOL).md5sum[:8])
ONE_ROBOT = SenderSettings(7, to_groups=False)


async def test_queries_change_nothing_and_a_drive_ends_with_a_halt_and_a_release() -> None:
    address, lines = loopback_group(), Lines()
    receiver = PlainReceiver(address)

    def flags() -> list[Flags]:
        return [decode_frame(each, NO_KEY).flags for each in receiver.datagrams]

    observer = FleetSender(FleetSettings(ONE_ROBOT, address), lines)
    await observer.query(0.06)
    observer.close()
    await until(lambda: receiver.datagrams)
    assert set(flags()) == {Flags.QUERY}
    receiver.datagrams.clear()
    sender = FleetSender(FleetSettings(ONE_ROBOT, address), lines)
    await sender.drive(b"go", 0.1)
    sender.close()
    await until(lambda: flags().count(Flags.RELEASE) == 3)
    assert lines.texts == [silence_text(FleetSettings(ONE_ROBOT, address))]
    # Before the first command and after the last.
    assert flags().count(Flags(0)) == 20
    assert set(flags()) == {Flags.ARMED, Flags(0), Flags.RELEASE}
    receiver.datagrams.clear()
    stopper = FleetSender(FleetSettings(ONE_ROBOT, address), lines)
    assert await stopper.stop() == []
    stopper.close()
    receiver.close()
    # The robot does not confirm the stop: there are three rounds.
    assert flags().count(Flags.STOP) == 30
    assert silence_text(FleetSettings(ONE_ROBOT, address)).startswith(
        f"robot 7 does not answer at {address}; check the key"
    )


async def test_a_drive_ends_after_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    address = loopback_group()
    receiver = PlainReceiver(address)
    sender = FleetSender(FleetSettings(ONE_ROBOT, address), Lines())
    clock_s = 0.0
    monkeypatch.setattr(fleet, "_now_with_suspend_s", lambda: clock_s)
    drive = asyncio.ensure_future(sender.drive(b"go"))

    def armed() -> int:
        return sum(decode_frame(each, NO_KEY).flags is Flags.ARMED for each in receiver.datagrams)

    await until(lambda: armed() > 5)
    clock_s = 60.0
    with pytest.raises(TransportError, match=r"paused for 60 s; start it again"):
        await drive
    count = armed()
    await until(lambda: decode_frame(receiver.datagrams[-1], NO_KEY).flags == Flags(0))
    sender.close()
    receiver.close()
    assert armed() == count


async def test_a_sender_whose_clock_was_ahead_is_stopped_and_followed() -> None:
    address, lines = loopback_group(), Lines()
    _, (node,) = await typed_nodes("/robots")
    robots = [
        receive_topic(
            node, ReceiverNodeSettings(BOOL, f"r{number}", address, framed=ReceiverSettings(number)), Lines()
        )
        for number in (7, 8)
    ]
    in_an_hour_us = time.time_ns() // 1000 + 3_600_000_000
    ahead = CommandSender(SenderSettings(kind=KIND), in_an_hour_us)
    channel = CommandChannel(address, Lines(), key=NO_KEY)
    channel.epoch_us = in_an_hour_us

    async def drive() -> None:
        while True:
            channel.send(ahead.command(b"\1", 0.0)[0])
            await asyncio.sleep(0.02)

    async with running(*robots, drive()):
        await until(lambda: [each.status.is_moving for each in channel.table.robots.values()] == [True, True])
        stopper = FleetSender(FleetSettings(address=address), lines)
        assert [has_stopped(each) for each in await stopper.stop()] == [True, True]
        stopper.close()
        follower = FleetSender(FleetSettings(replace(ONE_ROBOT, kind=KIND), address), lines)
        # It would fail if the robot refused it.
        await follower.drive(b"\1", 0.1)
        (robot,) = follower.robots
        assert robot.status.refusal is Refusal.NONE
        follower.close()
    channel.close()


async def test_a_stop_that_a_robot_refuses_is_not_confirmed() -> None:
    address = loopback_group()
    robot = PlainReceiver(address)
    stopper = FleetSender(FleetSettings(ONE_ROBOT, address), Lines())
    stopping = asyncio.ensure_future(stopper.stop())
    await until(lambda: robot.datagrams)
    frame = decode_frame(robot.datagrams[0], NO_KEY)
    # A board with an earlier library does not report the sender that it obeyed.
    status = RobotStatus(7, frame.epoch_us, 100, is_moving=True, refusal=Refusal.OLDER)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as answers:
        answers.sendto(status.encode(), robot.sources[0])
    assert [has_stopped(each) for each in await stopping] == [False]
    stopper.close()
    robot.close()


async def test_addresses_that_are_wrong() -> None:
    named = FleetSettings(address=GroupAddress("robots"))
    with pytest.raises(ConfigError, match="'robots' is not a numeric IP address"):
        FleetSender(named, Lines())
    with pytest.raises(ConfigError, match="'robots' is not a numeric IP address"):
        await examine(named, Lines(), 0.0)
    with pytest.raises(ConfigError, match="at most 100 unicast addresses"):
        FleetSender(FleetSettings(unicast=("10.0.0.1",) * 101), Lines())
