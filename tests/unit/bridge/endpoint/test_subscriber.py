from __future__ import annotations

import pytest

from rostether.bridge.endpoint.subscriber import SubscriberEndpoint
from unit.bridge.doubles import FakeLine
from unit.bridge.nodes import STORE, World, text, topic_info
from waiting import until

STRING = STORE.registry.message_type("std_msgs/String")


def endpoint(world: World, type_name: str = "std_msgs/String", buffer_size: int = 280) -> SubscriberEndpoint:
    return SubscriberEndpoint(
        topic_info("led", type_name, topic_id=100, buffer_size=buffer_size),
        STORE,
        world.board,
        world.notices,
    )


@pytest.fixture
async def world() -> World:
    return await World().open()


async def test_messages_reach_the_board_in_order(world: World) -> None:
    line, led = FakeLine(), endpoint(world)
    led.attach(line, led.info)
    await led.open()
    publisher = await world.peer.advertise("/led", STRING)
    publisher.publish_raw([text("on"), text("off")])
    await until(lambda: line.transport.written, "the messages")
    assert line.transport.written == b"100:" + text("on") + b";100:" + text("off") + b";"
    assert led.message_count == 2


async def test_messages_larger_than_the_boards_buffer_are_not_sent(world: World) -> None:
    line, led = FakeLine(), endpoint(world, buffer_size=20)
    led.attach(line, led.info)
    for _ in range(50):
        led.deliver([text("x" * 16), text("x" * 17), text("x" * 300)])
    await until(lambda: line.transport.written.count(b"100:") == 50, "what fits")
    (reported,) = world.reporter.texts
    for part in ("led", "std_msgs/String", "304 bytes", "20"):
        assert part in reported


async def test_a_type_that_never_fits_is_reported_immediately(world: World) -> None:
    led = endpoint(world, "std_msgs/Float64", buffer_size=4)
    led.attach(FakeLine(), led.info)
    assert "8 bytes" in world.reporter.texts[0]


async def test_a_publishers_malformed_message_never_reaches_the_board(world: World) -> None:
    line, led = FakeLine(), endpoint(world)
    led.attach(line, led.info)
    led.deliver([b"\xff\xff\xff\xff", text("good")])
    led.deliver([b"\x01"])
    await until(lambda: line.transport.written, "the good message")
    assert line.transport.written == b"100:" + text("good") + b";"
    assert led.misfit_count == 2
    assert len(world.reporter.texts) == 1
    # It is too long for the board, so it is not checked: that is slow for many MB.
    led.deliver([b"\xff\xff\xff\xff" + bytes(300)])
    assert led.misfit_count == 2
    assert "304 bytes" in world.reporter.texts[1]


async def test_messages_are_dropped_while_detached(world: World) -> None:
    line, led = FakeLine(), endpoint(world)
    led.attach(line, led.info)
    await led.open()
    led.detach()
    led.deliver([text("lost")])
    led.attach(line, led.info)
    led.deliver([text("kept")])
    await until(lambda: line.transport.written, "the kept message")
    assert line.transport.written == b"100:" + text("kept") + b";"


async def test_an_overflowing_board_pauses_the_subscription(world: World) -> None:
    line, led = FakeLine(), endpoint(world)
    led.attach(line, led.info)
    await led.open()
    publisher = await world.peer.advertise("/led", STRING)
    line.outbox.pause_writing()
    for _ in range(1000):
        if not publisher.publish_raw([text("x" * 200)] * 100):
            break
        await until(lambda: True, "one turn")
    assert not publisher.publish_raw([text("x")])
    line.outbox.resume_writing()
    await publisher.drained(5.0)
    assert publisher.publish_raw([text("last")])
    await until(lambda: text("last") in line.transport.written, "the last message")
    assert led.dropped_count == 0


async def test_renewing_delivers_latched_messages_again(world: World) -> None:
    publisher = await world.peer.advertise("/led", STRING, latch=True)
    publisher.publish_raw([text("latched")])
    line, led = FakeLine(), endpoint(world)
    led.attach(line, led.info)
    await led.open()
    await until(lambda: line.transport.written, "the latched message")
    assert led.has_latched_source
    await led.renew()
    await until(lambda: line.transport.written.count(b"latched") == 2, "the latched message again")


async def test_closing_leaves_the_graph(world: World) -> None:
    led = endpoint(world)
    await led.open()
    await led.close()
    await led.close()
    assert "/led" not in world.network.snapshot().topics


async def test_drops_of_earlier_connections_still_count(world: World) -> None:
    line, led = FakeLine(can_pause=False), endpoint(world)
    led.attach(line, led.info)
    line.outbox.pause_writing()
    led.deliver([text("x" * 200)] * 2000)
    dropped = led.dropped_count
    assert dropped > 0
    assert line.dropped == [("led", dropped)]
    led.detach()
    led.attach(FakeLine(), led.info)
    assert led.dropped_count == dropped
