from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import AsyncIterator

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.platform import multicast_receiver
from rostether.platform.command_link import CommandSender, ReceiverSettings, SenderSettings
from rostether.platform.multicast_receiver import ReceiverNodeSettings, receive_topic
from rostether.platform.multicast_socket import GroupAddress, open_receiver, open_sender
from unit.platform.datagrams import GROUPS, IPV6_INTERFACE, LINK_GROUP, loopback_group, running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until

CONTROL = "arduino_control/ArduinoControl"
EXAMPLE = bytes.fromhex("0000000000000080000000000000f03f")
KEY = b"0123456789abcdef"
KIND = bytes.fromhex("7528cb4c")


class Robot:
    """Collects the messages of a robot's topic."""

    def __init__(self) -> None:
        self.speeds: list[float] = []

    async def listen(self, node: TypedGraph) -> None:
        async for message in node.messages("/multicast_topic", CONTROL):
            self.speeds.append(message.speed)


def sender_to(address: GroupAddress) -> socket.socket:
    sock = open_sender(address, address.interfaces[0])
    sock.connect((address.group, address.port))
    return sock


@pytest.mark.parametrize("group", GROUPS)
async def test_bare_datagrams_are_published_if_they_fit(group: str) -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_receiver", "/robot")
    address, lines, robot = loopback_group(group), Lines(), Robot()
    settings = ReceiverNodeSettings(CONTROL, address=address)
    async with running(robot.listen(other), receive_topic(node, settings, lines)):
        await until(lambda: lines.texts)
        with sender_to(address) as sock:
            for datagram in (EXAMPLE[:-1], EXAMPLE + b"\0", b"", EXAMPLE):
                sock.send(datagram)
            await until(lambda: robot.speeds and len(lines.texts) == 4)
    assert robot.speeds == [1.0]
    assert lines.texts[0] == f"receiving {CONTROL} from {address} as /multicast_topic"
    assert "ends 1 byte early in field 'speed'" in lines.texts[1]


@pytest.mark.skipif(not IPV6_INTERFACE, reason="this machine has no IPv6")
def test_a_group_of_one_link_binds_no_interface() -> None:
    # The interface may be unplugged, and another one may have its name later.
    with open_receiver(loopback_group(LINK_GROUP)) as sock:
        assert sock.getsockname()[3] == 0


async def test_other_machines_are_ignored_until_they_are_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_receiver", "/robot")
    address, lines, robot = loopback_group(), Lines(), Robot()
    # Datagrams of this machine have an address that the list does not contain.
    monkeypatch.setattr("rostether.transports.allow_list.ALWAYS_ALLOWED", ())
    monkeypatch.setattr(multicast_receiver, "is_own_address", lambda *_: False)
    settings = ReceiverNodeSettings(CONTROL, address=address, sources=("10.0.0.0/8",))
    async with running(robot.listen(other), receive_topic(node, settings, lines)):
        await until(lambda: lines.texts)
        with sender_to(address) as sock:
            host = sock.getsockname()[0]
            sock.send(EXAMPLE)
            await until(lambda: len(lines.texts) == 2)
    assert lines.texts[1] == f"ignored a datagram from {host}: allow it with _sources:={host}"
    assert robot.speeds == []


@contextlib.asynccontextmanager
async def framed_robot() -> AsyncIterator[tuple[Robot, Lines, CommandSender, socket.socket]]:
    """A robot that follows framed commands, and a sender to it."""
    _, (node, other) = await typed_nodes("/multicast_topic_receiver", "/robot")
    address, lines, robot = loopback_group(), Lines(), Robot()
    framed = ReceiverSettings(3, kind=KIND, key=KEY)
    settings = ReceiverNodeSettings(CONTROL, address=address, framed=framed, has_key=True)
    sender = CommandSender(SenderSettings(3, to_groups=False, kind=KIND, key=KEY), 1_000)
    async with running(robot.listen(other), receive_topic(node, settings, lines)):
        await until(lambda: lines.texts)
        with sender_to(address) as sock:
            yield robot, lines, sender, sock


async def test_a_framed_robot_stops_on_request_and_when_its_sender_disappears() -> None:
    async with framed_robot() as (robot, lines, sender, sock):
        sock.send(EXAMPLE)
        first = sender.command(EXAMPLE, 0.0)[0]
        sock.send(first)
        sock.send(sender.stop(0.0)[0])
        await until(lambda: robot.speeds == [1.0, 0.0])
        sock.send(first)
        sock.send(sender.command(EXAMPLE, 0.0)[0])
        # After the last command, the time to live of 300 ms stops the robot.
        await until(lambda: robot.speeds == [1.0, 0.0, 1.0, 0.0])
    assert "is not a framed command" in lines.texts[1]
    assert lines.texts[2:] == ["no command within the time to live; stopping /multicast_topic"]


async def test_a_robot_stops_if_a_query_is_read_before_the_watchdog_runs() -> None:
    async with framed_robot() as (robot, lines, sender, sock):
        sock.send(sender.command(EXAMPLE, 0.0)[0])
        await until(lambda: robot.speeds == [1.0])
        # The event loop is blocked until the time to live has passed, and then reads first.
        sock.send(sender.query())
        time.sleep(0.4)
        await until(lambda: robot.speeds == [1.0, 0.0])
    assert lines.texts[1:] == ["no command within the time to live; stopping /multicast_topic"]


async def test_a_robot_that_moves_is_stopped_when_its_receiver_ends() -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_receiver", "/robot")
    address, lines, robot = loopback_group(), Lines(), Robot()
    settings = ReceiverNodeSettings(CONTROL, address=address, framed=ReceiverSettings(3, kind=KIND))
    sender = CommandSender(SenderSettings(3, to_groups=False, kind=KIND, ttl_ms=1000), 1_000)
    async with running(robot.listen(other)):
        async with running(receive_topic(node, settings, lines)):
            await until(lambda: lines.texts)
            with sender_to(address) as sock:
                sock.send(sender.command(EXAMPLE, 0.0)[0])
                await until(lambda: robot.speeds == [1.0])
        await until(lambda: robot.speeds == [1.0, 0.0])


async def test_an_interface_that_comes_later(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(multicast_receiver, "SILENCE_S", 0.01)
    _, (node, other) = await typed_nodes("/multicast_topic_receiver", "/robot")
    address, lines, robot = loopback_group(), Lines(), Robot()
    names = {"later": 0}

    def index_of(name: str) -> int:
        if not names[name]:
            raise OSError(19, "No such device")
        return names[name]

    lo = socket.if_nametoindex("lo")
    monkeypatch.setattr("rostether.platform.multicast_socket.socket.if_nametoindex", index_of)
    settings = ReceiverNodeSettings(CONTROL, address=replace(address, interfaces=("later",)))
    async with running(robot.listen(other), receive_topic(node, settings, lines)):
        await until(lambda: len(lines.texts) == 2)
        assert lines.texts[1].startswith(f"cannot join {address.group} on later: No such device")
        names.update(later=lo, lo=lo)
        with sender_to(address) as sock:
            async with asyncio.timeout(60):
                while not robot.speeds:
                    sock.send(EXAMPLE)
                    await asyncio.sleep(0.01)


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (ReceiverNodeSettings(CONTROL, address=GroupAddress("x")), "not a numeric IP address"),
        (ReceiverNodeSettings(CONTROL, sources=("lab",)), "~sources: 'lab' is not a network"),
        (
            ReceiverNodeSettings(CONTROL, address=GroupAddress("192.0.2.1")),
            "cannot receive at 192.0.2.1:12345",
        ),
    ],
)
async def test_settings_that_make_no_sense(settings: ReceiverNodeSettings, reason: str) -> None:
    _, (node,) = await typed_nodes("/multicast_topic_receiver")
    with pytest.raises(ConfigError, match=reason):
        await receive_topic(node, settings, Lines())
