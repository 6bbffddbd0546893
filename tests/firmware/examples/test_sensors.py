"""Examples with sensors: they publish the values that the simulated surroundings have."""

from __future__ import annotations

import math

import pytest

from firmware.examples.stage import running

RANGE = "sensor_msgs/Range"


async def test_ultrasound(kind: str) -> None:
    async with running("Ultrasound", kind, ["hcsr04 trig=D6,echo=D5", "range 0.5"]) as stage:
        inbox = await stage.listen("/ultrasound", RANGE)
        for meters in (0.5, 0.03, 1.234, 2.9):
            await stage.board.set_range(meters)
            await inbox.next_messages(2)  # one message may have been pending
            for measured in await inbox.next_messages(3):
                assert measured.range == pytest.approx(meters, abs=0.01)
        await stage.board.set_range(None)
        assert math.isinf((await inbox.wait_for(lambda measured: measured.range > 4)).range)

        last, first = inbox.messages[-1], inbox.messages[0]
        assert last.radiation_type == 0
        assert last.header.frame_id == "ultrasound"
        assert last.min_range == pytest.approx(0.02)
        assert last.max_range == pytest.approx(4.0)
        assert last.header.stamp > first.header.stamp


async def test_ultrasound_measures_twenty_times_a_second() -> None:
    async with running("Ultrasound", commands=["hcsr04 trig=D6,echo=D5", "range 1"]) as stage:
        inbox = await stage.listen("/ultrasound", RANGE)
        stamps = [message.header.stamp.to_s() for message in (await inbox.next_messages(20))[4:]]
        assert (stamps[-1] - stamps[0]) / (len(stamps) - 1) == pytest.approx(0.05, rel=0.1)


async def test_ir_ranger(kind: str) -> None:
    async with running("IrRanger", kind) as stage:
        inbox = await stage.listen("/range_data", RANGE)
        for centimeters in (4.5, 10, 17, 25):
            await stage.board.set_adc("A0", 12.2 / (centimeters + 0.42))
            await inbox.next_messages(2)
            for measured in await inbox.next_messages(2):
                assert measured.range == pytest.approx(centimeters / 100, abs=0.005)
                assert measured.radiation_type == 1
        await stage.board.set_adc("A0", 0.1)
        assert math.isinf((await inbox.wait_for(lambda measured: measured.range > 1)).range)


async def test_temperature(kind: str) -> None:
    async with running("Temperature", kind, ["adc A0=0.75"]) as stage:
        inbox = await stage.listen("/temperature", "std_msgs/Float32")
        assert (await inbox.wait_for()).data == pytest.approx(25, abs=0.5)
        await stage.board.set_adc("A0", 0.4)
        assert (await inbox.wait_for(lambda measured: measured.data < 0)).data == pytest.approx(-10, abs=0.5)


async def test_adc(kind: str) -> None:
    volts = {"A0": 0.0, "A1": 1.0, "A2": 2.5, "A3": 3.3, "A4": 4.2, "A5": 5.0}
    commands = "adc " + " ".join(f"{pin}={value}" for pin, value in volts.items())
    async with running("ADC", kind, [commands]) as stage:
        inbox = await stage.listen("/adc", "rosserial_arduino/Adc")
        await inbox.next_messages(2)
        adc = await inbox.wait_for()
        for index, value in enumerate(volts.values()):
            assert getattr(adc, f"adc{index}") == pytest.approx(min(value / 5 * 1024, 1023), abs=1)


async def test_clapper(kind: str) -> None:
    async with running("Clapper", kind) as stage:
        board = stage.board
        claps = await stage.listen("/clap", "std_msgs/Empty")

        async def clap(pause: str) -> None:
            await board.set_adc("A0", 3.0)
            await board.run("30ms")
            await board.set_adc("A0", 0.0)
            await board.run(pause)

        # The board is paused from here on, so that a clap has the same length on a busy machine.
        await board.run("1ms")
        await clap("800ms")  # one clap alone has no effect
        await clap("250ms")
        await clap("800ms")
        await clap("250ms")
        await clap("800ms")
        await board.send_command("run")
        await claps.wait_for_count(2)
        assert len(claps.messages) == 2
