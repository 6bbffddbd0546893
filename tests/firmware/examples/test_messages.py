"""Examples with texts, LEDs and buttons."""

from __future__ import annotations

import itertools

import pytest

from effort import effort
from firmware.examples.stage import running

EMPTY = "std_msgs/Empty"


@pytest.fixture(params=effort(["uno"], ["uno", "mega"]))
def kind(request: pytest.FixtureRequest) -> str:
    """The Mega has the same pins for these; the other examples run on both."""
    return str(request.param)


async def test_hello_world(kind: str) -> None:
    async with running("HelloWorld", kind) as stage:
        assert (await stage.message("/chatter", "std_msgs/String")).data == "hello world!"


async def test_blink(kind: str) -> None:
    async with running("Blink", kind) as stage:
        toggle = await stage.publisher("/toggle_led", EMPTY)
        for level in (True, False, True):
            toggle.publish()
            await stage.board.wait_for_pin("D13", level)


async def test_blinker_with_class(kind: str) -> None:
    async with running("BlinkerWithClass", kind) as stage:
        board = stage.board
        period = await stage.publisher("/set_blink_period", "std_msgs/UInt16")
        # While the board announces its topics, which takes up to 33 ms, it does not blink.
        await stage.wait_for_service("/activate_blinker")
        period.publish(data=50)
        for level in (True, False) * 4:
            await board.wait_for_pin("D13", level)
        edges_s = [event.time_s for event in board.recent if event.name == "pin"][-4:]
        gaps_ms = [1000 * (after - before) for before, after in itertools.pairwise(edges_s)]
        assert gaps_ms == pytest.approx([50] * 3, abs=4)

        answer = await stage.graph.call(
            "/activate_blinker", "std_srvs/SetBool", {"data": False}, timeout_s=60
        )
        assert (answer.success, answer.message) == (True, "dark")
        assert not await board.pin_level("D13")
        answer = await stage.graph.call("/activate_blinker", "std_srvs/SetBool", {"data": True}, timeout_s=60)
        assert answer.message == "blinking"
        await board.wait_for_pin("D13", True)


async def test_pubsub(kind: str) -> None:
    async with running("pubsub", kind) as stage:
        toggle = await stage.publisher("/toggle_led", EMPTY)
        toggle.publish()
        await stage.board.wait_for_pin("D13", True)
        assert (await stage.message("/chatter", "std_msgs/String")).data == "hello world!"


async def test_led_byte(kind: str) -> None:
    async with running("LedByte", kind) as stage:
        led_out = await stage.publisher("/led_out", "std_msgs/Byte")
        for number in (5, 10, 15, 0, 8):
            led_out.publish(data=number)
            for bit in range(4):
                await stage.board.wait_for_pin(f"D{4 + bit}", bool(number & 1 << bit))


async def test_button_example(kind: str) -> None:
    async with running("button_example", kind) as stage:
        board = stage.board
        pushed = await stage.listen("/pushed", "std_msgs/Bool")
        # The board must not run between these commands, as it may on a busy machine.
        await board.send_command("pause")
        for level in (False, True, False, True, False):  # it bounces
            await board.drive_pin("D7", level)
            await board.run("2ms")
        await board.send_command("run")
        await pushed.wait_for_count(1)
        assert await board.pin_level("D13")
        await board.drive_pin("D7", None)
        await pushed.wait_for_count(2)
        assert [each.data for each in pushed.messages] == [True, False]


async def test_blinkm_sends_colors_and_reports_a_missing_light(kind: str) -> None:
    # The simulated board has no BlinkM: the bytes for it are in the buffer of the I2C library.
    async with running("BlinkM", kind) as stage:
        log = await stage.listen_to_log()
        blinkm = await stage.publisher("/blinkm", "std_msgs/String")
        for text, sent in (("Sm", b"n\xff\x00\xff"), ("g", b"c\x00\xff\x00"), ("So", b"n\x00\x00\x00")):
            blinkm.publish(data=text)
            await stage.wait_for_memory("_ZN7TwoWire8txBufferE", sent)
        blinkm.publish(data="")
        await log.wait_for(lambda line: line.msg == "colors are: r g b y c m w o")
        assert "no BlinkM answers on I2C" in [line.msg for line in log.messages]
