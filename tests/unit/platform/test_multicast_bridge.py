from __future__ import annotations

import asyncio
import time

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.platform.command_frame import CommandFrame, Flags, decode_frame
from rostether.platform.command_link import SenderSettings
from rostether.platform.multicast_bridge import BridgeNodeSettings, send_topic
from rostether.platform.multicast_socket import GroupAddress
from unit.platform.datagrams import GROUPS, PlainReceiver, loopback_group, running
from unit.platform.typed_nodes import Lines, typed_nodes
from waiting import until

CONTROL = "arduino_control/ArduinoControl"
EXAMPLE = bytes.fromhex("0000000000000080000000000000f03f")


async def published(node: TypedGraph) -> TypedPublisher[...]:
    publisher = await node.publisher("/multicast_topic", CONTROL)
    await until(lambda: publisher.subscriber_count)
    return publisher


@pytest.mark.parametrize("group", [*GROUPS, "224.0.1.1"])
async def test_a_datagram_is_the_references(group: str) -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_bridge", "/other")
    address = loopback_group(group)
    receiver, lines = PlainReceiver(address), Lines()
    async with running(send_topic(node.raw, BridgeNodeSettings(address=address, frequency_hz=0), lines)):
        publisher = await published(other)
        publisher.publish(dir=-0.0, speed=1.0)
        await until(lambda: receiver.datagrams)
        publisher.publish(dir=90.0, speed=0.5)
        await until(lambda: len(receiver.datagrams) == 2)
    receiver.close()
    assert receiver.datagrams[0] == EXAMPLE
    assert receiver.sources[0][1] != address.port
    assert lines.texts == [f"sending /multicast_topic to {address}"]


async def test_only_the_newest_message_is_sent_and_once() -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_bridge", "/other")
    address = loopback_group()
    receiver = PlainReceiver(address)
    async with running(send_topic(node.raw, BridgeNodeSettings(address=address, frequency_hz=4), Lines())):
        publisher = await published(other)
        for speed in (1.0, 2.0, 3.0):
            publisher.publish(speed=speed)
        await until(lambda: receiver.datagrams)
        for speed in (4.0, 5.0, 6.0):
            publisher.publish(speed=speed)
        await until(lambda: len(receiver.datagrams) == 2)
        publisher.publish(speed=7.0)
        await until(lambda: len(receiver.datagrams) == 3)
    receiver.close()
    speeds = [other.store.codec(CONTROL).decode(each).speed for each in receiver.datagrams]
    assert speeds == [3.0, 6.0, 7.0]


async def test_a_thousand_messages_a_second_are_a_limit_and_no_busy_loop() -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_bridge", "/other")
    address = loopback_group()
    receiver = PlainReceiver(address)
    async with running(send_topic(node.raw, BridgeNodeSettings(address=address), Lines())):
        publisher = await published(other)
        began_s = time.monotonic()
        while time.monotonic() < began_s + 0.5 or len(receiver.datagrams) <= 10:
            publisher.publish(speed=1.0)
            await asyncio.sleep(0)
        spent_s = time.monotonic() - began_s
        assert len(receiver.datagrams) <= 1000 * spent_s + 10
        # During silence, nothing is sent.
        await asyncio.sleep(0.01)
        cpu_s = time.thread_time()
        await asyncio.sleep(0.5)
        assert time.thread_time() - cpu_s < 0.1
    receiver.close()


async def test_a_failed_send_is_reported_once_and_tried_again() -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_bridge", "/other")
    address = replace(loopback_group(), interfaces=("no_such_if",))
    lines = Lines()
    async with running(send_topic(node.raw, BridgeNodeSettings(address=address), lines)):
        publisher = await published(other)
        publisher.publish(speed=1.0)
        await until(lambda: len(lines.texts) == 2)
        publisher.publish(speed=1.0)
        await asyncio.sleep(0.05)
    assert lines.texts[1].startswith(f"cannot send to {address} by no_such_if: ")
    assert len(lines.texts) == 2


async def test_a_message_that_fits_no_datagram() -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_bridge", "/other")
    lines = Lines()
    async with running(
        send_topic(node.raw, BridgeNodeSettings(topic="/big", address=loopback_group()), lines)
    ):
        publisher = await other.publisher("/big", "std_msgs/String")
        await until(lambda: publisher.subscriber_count)
        publisher.publish(data="x" * 65_504)
        await until(lambda: len(lines.texts) == 2)
    too_large = "a message of 65508 bytes is not sent: a datagram contains at most 65507;"
    assert lines.texts[1] == f"{too_large} publish smaller messages"


async def test_framed_commands_are_repeated_and_end_with_a_stop() -> None:
    _, (node, other) = await typed_nodes("/multicast_topic_bridge", "/other")
    address, key = loopback_group(), b"0123456789abcdef"
    receiver = PlainReceiver(address)
    framed = SenderSettings(3, to_groups=False, key=key)

    def frames() -> list[CommandFrame]:
        return [decode_frame(each, key) for each in receiver.datagrams]

    settings = BridgeNodeSettings(address=address, framed=framed, input_timeout_s=1.0)
    async with running(send_topic(node.raw, settings, Lines())):
        publisher = await published(other)
        publisher.publish(dir=-0.0, speed=1.0)
        await until(lambda: sum(each.flags == Flags(0) for each in frames()) == 10)
        armed = [each for each in frames() if Flags.ARMED in each.flags]
        assert len(armed) > 3
        assert {(each.payload, each.kind.hex(), each.target) for each in armed} == {(EXAMPLE, "7528cb4c", 3)}
        assert [each.sequence for each in frames()] == list(range(1, len(armed) + 11))
    await until(lambda: sum(Flags.RELEASE in each.flags for each in frames()) == 3)
    receiver.close()


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (BridgeNodeSettings(frequency_hz=-1), "~frequency must be from 0"),
        (BridgeNodeSettings(frequency_hz=float("nan")), "~frequency must be from 0"),
        (BridgeNodeSettings(address=GroupAddress("robots")), "'robots' is not a numeric IP address"),
        (
            BridgeNodeSettings(input_timeout_s=-1),
            "~input_timeout must be a time in seconds, or 0",
        ),
    ],
)
async def test_settings_that_make_no_sense(settings: BridgeNodeSettings, reason: str) -> None:
    _, (node,) = await typed_nodes("/multicast_topic_bridge")
    with pytest.raises(ConfigError, match=reason):
        await send_topic(node.raw, settings, Lines())
