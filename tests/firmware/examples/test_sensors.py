"""Examples with sensors: they publish the values that the simulated surroundings have."""

from __future__ import annotations

import math

import pytest

from firmware.examples.stage import running

RANGE = "sensor_msgs/Range"


async def test_ultrasound(kind: str) -> None:
    async with running("Ultrasound", kind, ["hcsr04 trig=D6,echo=D5", "range 0.5"]) as stage:
        received = await stage.listen("/ultrasound", RANGE)
        for meters in (0.5, 0.03, 1.234, 2.9):
            await stage.board.set_range(meters)
            await received.several(2)  # one message may have been pending
            for measured in await received.several(3):
                assert measured.range == pytest.approx(meters, abs=0.01)
        await stage.board.set_range(None)
        assert math.isinf((await received.next(lambda measured: measured.range > 4)).range)

        last, former = received.received[-1], received.received[0]
        assert last.radiation_type == 0
        assert last.header.frame_id == "ultrasound"
        assert last.min_range == pytest.approx(0.02)
        assert last.max_range == pytest.approx(4.0)
        assert last.header.stamp > former.header.stamp


async def test_ultrasound_measures_twenty_times_a_second() -> None:
    async with running("Ultrasound", words=["hcsr04 trig=D6,echo=D5", "range 1"]) as stage:
        received = await stage.listen("/ultrasound", RANGE)
        stamps = [message.header.stamp.to_s() for message in (await received.several(20))[4:]]
        assert (stamps[-1] - stamps[0]) / (len(stamps) - 1) == pytest.approx(0.05, rel=0.1)


async def test_ir_ranger(kind: str) -> None:
    async with running("IrRanger", kind) as stage:
        received = await stage.listen("/range_data", RANGE)
        for centimeters in (4.5, 10, 17, 25):
            await stage.board.set_adc("A0", 12.2 / (centimeters + 0.42))
            await received.several(2)
            for measured in await received.several(2):
                assert measured.range == pytest.approx(centimeters / 100, abs=0.005)
                assert measured.radiation_type == 1
        await stage.board.set_adc("A0", 0.1)
        assert math.isinf((await received.next(lambda measured: measured.range > 1)).range)


async def test_temperature(kind: str) -> None:
    async with running("Temperature", kind, ["adc A0=0.75"]) as stage:
        received = await stage.listen("/temperature", "std_msgs/Float32")
        assert (await received.next()).data == pytest.approx(25, abs=0.5)
        await stage.board.set_adc("A0", 0.4)
        assert (await received.next(lambda measured: measured.data < 0)).data == pytest.approx(-10, abs=0.5)


async def test_adc(kind: str) -> None:
    volts = {"A0": 0.0, "A1": 1.0, "A2": 2.5, "A3": 3.3, "A4": 4.2, "A5": 5.0}
    words = "adc " + " ".join(f"{pin}={value}" for pin, value in volts.items())
    async with running("ADC", kind, [words]) as stage:
        received = await stage.listen("/adc", "rosserial_arduino/Adc")
        await received.several(2)
        adc = await received.next()
        for index, value in enumerate(volts.values()):
            assert getattr(adc, f"adc{index}") == pytest.approx(min(value / 5 * 1024, 1023), abs=1)


async def test_clapper(kind: str) -> None:
    async with running("Clapper", kind) as stage:
        board = stage.board
        claps = await stage.listen("/clap", "std_msgs/Empty")

        async def hear_one(then: str) -> None:
            await board.set_adc("A0", 3.0)
            await board.run("30ms")
            await board.set_adc("A0", 0.0)
            await board.run(then)

        # The board is paused from here on, so that a clap has the same length on a busy machine.
        await board.run("1ms")
        await hear_one("800ms")  # one clap alone has no effect
        await hear_one("250ms")
        await hear_one("800ms")
        await hear_one("250ms")
        await hear_one("800ms")
        await board.send_command("run")
        await claps.reached(2)
        assert len(claps.received) == 2
