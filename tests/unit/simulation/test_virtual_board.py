from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import NamedTuple

import pytest

from line_faults import FaultRates, LineFaults
from rostether.device import Device
from rostether.rosserial.events import TopicRole
from rostether.rosserial.packets import LogLevel
from rostether.simulation.ultrasound import MAX_RANGE, MIN_RANGE
from rostether.simulation.virtual_board import VirtualBoard
from rostether.transports.memory import memory_pair
from rostether.transports.opening import listen
from unit.device.host import HOST_TIME, STORE, Host, Hosts, hosting
from waiting import until

TOPICS = {
    "led": "std_msgs/Bool",
    "ultrasound": "sensor_msgs/Range",
    "imu_data": "sensor_msgs/Imu",
    "/tf": "tf/tfMessage",
    "count": "std_msgs/UInt32",
}


class Clock:
    def __init__(self) -> None:
        self.now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


class Bench(NamedTuple):
    """A board under test, with a clock that only the test changes."""

    board: VirtualBoard
    device: Device
    host: Host
    clock: Clock

    async def play(self, seconds: float) -> None:
        end_s = self.clock.now_s + seconds
        due_s = self.board.step(self.clock.now_s)
        while due_s < end_s:
            self.clock.now_s = due_s
            due_s = self.board.step(due_s)
            await asyncio.sleep(0)
        self.clock.now_s = end_s

    async def until_counted(self, topic: str, count: int) -> None:
        await self.host.until(lambda: len(self.host.messages[topic]) >= count)


@pytest.fixture
async def bench() -> AsyncIterator[Bench]:
    near, far = memory_pair()
    clock = Clock()
    device = Device(near, store=STORE)
    board = VirtualBoard(device, clock=clock, seed=1)
    async with hosting(far) as host, device:
        await host.until(lambda: host.settled and ("toggle_led", TopicRole.SUBSCRIBER) in host.announced)
        await until(lambda: device.now().secs >= HOST_TIME.secs)
        yield Bench(board, device, host, clock)


async def test_announce_the_endpoints(bench: Bench) -> None:
    announced = bench.host.announced
    assert {name: announced[name, TopicRole.PUBLISHER].info.message_type for name in TOPICS} == TOPICS
    assert announced["toggle_led", TopicRole.SUBSCRIBER].info.message_type == "std_msgs/Empty"
    assert {name: service.type for name, service in bench.host.services.items()} == {
        "set_led": "std_srvs/SetBool",
        "test_srv": "rosserial_arduino/Test",
    }


async def test_publish_each_topic_at_its_rate(bench: Bench) -> None:
    await bench.play(10.0)
    await bench.until_counted("imu_data", 400)
    counts = {topic: len(bench.host.messages[topic]) for topic in TOPICS}
    assert counts == {"led": 10, "ultrasound": 200, "imu_data": 400, "/tf": 200, "count": 10}
    assert [message.data for message in bench.host.messages["count"]] == list(range(10))


async def test_missed_repetitions_are_skipped(bench: Bench) -> None:
    bench.board.step(bench.clock.now_s + 60.0)
    due_s = bench.board.step(bench.clock.now_s + 60.0)
    assert due_s > bench.clock.now_s + 60.0
    await bench.until_counted("imu_data", 1)
    assert len(bench.host.messages["imu_data"]) == 1


async def test_ranges_are_those_of_an_hc_sr04(bench: Bench) -> None:
    await bench.play(5.0)
    await bench.until_counted("ultrasound", 100)
    for message in bench.host.messages["ultrasound"]:
        assert message.min_range == pytest.approx(MIN_RANGE)
        assert message.max_range == pytest.approx(MAX_RANGE)
        assert message.min_range <= message.range <= message.max_range
        assert message.header.frame_id == "ultrasound"
        assert message.header.stamp.secs >= HOST_TIME.secs
    assert len({message.range for message in bench.host.messages["ultrasound"]}) > 50


async def test_imu_and_tf_turn_together(bench: Bench) -> None:
    await bench.play(0.01)
    await bench.until_counted("imu_data", 1)
    await bench.until_counted("/tf", 1)
    imu, transform = bench.host.messages["imu_data"][0], bench.host.messages["/tf"][0].transforms[0]
    assert imu.orientation == transform.transform.rotation
    assert imu.linear_acceleration.z == pytest.approx(9.8, abs=0.3)
    assert imu.orientation_covariance[0] > 0
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "base_link")
    assert imu.header.frame_id == "base_link"


async def test_toggle_the_led(bench: Bench) -> None:
    for on in (True, False):
        bench.host.publish("toggle_led", {})
        await until(lambda on=on: bench.board.led is on)  # type: ignore[misc]
    await bench.until_counted("led", 2)
    await bench.host.until(lambda: len(bench.host.logs) == 2)
    assert [message.data for message in bench.host.messages["led"]] == [True, False]
    assert [(log.level, log.text) for log in bench.host.logs] == [
        (LogLevel.INFO, "LED on"),
        (LogLevel.INFO, "LED off"),
    ]


async def test_services_answer(bench: Bench) -> None:
    answer = await bench.host.call("set_led", {"data": True})
    assert (answer.success, answer.message, bench.board.led) == (True, "LED on", True)
    assert (await bench.host.call("set_led", {"data": True})).message == "LED on already"
    assert (await bench.host.call("test_srv", {"input": "world"})).output == "hello, world"


async def test_parameters_decide_blinking_and_frame(bench: Bench) -> None:
    bench.host.params = {"~blink_hz": ((5,), (), ()), "~frame_id": ((), (), ("base_footprint",))}
    await bench.board.read_parameters()
    await bench.play(1.0)
    await bench.until_counted("led", 10)
    states = [message.data for message in bench.host.messages["led"]]
    assert states.count(True) == pytest.approx(states.count(False), abs=2)
    await bench.until_counted("/tf", 20)
    robot, sensor = bench.host.messages["/tf"][-1].transforms
    assert robot.child_frame_id == sensor.header.frame_id == "base_footprint"
    assert sensor.child_frame_id == bench.host.messages["ultrasound"][-1].header.frame_id
    bench.host.params = {"~blink_hz": ((0,), (), ())}
    await bench.board.read_parameters()
    seen = len(bench.host.messages["led"])
    await bench.play(1.0)
    await bench.until_counted("count", 2)
    assert len(bench.host.messages["led"]) - seen <= 1


@pytest.mark.parametrize("wrong", [((-1,), (), ()), ((), (), ("fast",)), ((1000,), (), ()), ((1, 2), (), ())])
async def test_an_invalid_parameter_is_reported_and_ignored(
    bench: Bench, wrong: tuple[tuple[int, ...], tuple[float, ...], tuple[str, ...]]
) -> None:
    bench.host.params = {"~blink_hz": wrong}
    await bench.board.read_parameters()
    await bench.host.until(lambda: bool(bench.host.logs))
    assert bench.host.logs[0].level is LogLevel.WARN
    assert "~blink_hz" in bench.host.logs[0].text
    await bench.play(0.5)
    assert bench.board.led is False


async def test_run_in_real_time_over_tcp() -> None:
    hosts = Hosts()
    listener = await listen("tcp://:0", hosts)
    device = Device(listener.address, store=STORE)
    board = VirtualBoard(device)
    async with device:
        running = asyncio.ensure_future(board.run())
        host = await hosts.next()
        host.params = {"~frame_id": ((), (), ("base_footprint",))}
        await host.until(lambda: len(host.messages["imu_data"]) > 10 and bool(host.logs))
        assert host.logs[0].text == "virtual board ready"
        await host.until(lambda: host.messages["imu_data"][-1].header.frame_id == "base_footprint")
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
    await hosts.close()
    await listener.close()


async def test_a_bad_line_loses_frames_but_not_the_session() -> None:
    faults = LineFaults(
        FaultRates(flip_per_byte=0.0005, lose_per_byte=0.0002, insert_per_byte=0.0002), seed=11
    )
    near, far = memory_pair(faults)
    clock = Clock()
    device = Device(near, store=STORE)
    board = VirtualBoard(device, clock=clock)
    async with hosting(far) as host, device:
        await host.until(lambda: host.settled)
        play = Bench(board, device, host, clock).play
        while faults.fault_count < 200:
            await play(1.0)
            await asyncio.sleep(0)
        await host.until(lambda: len(host.messages["imu_data"]) > 100)
        # The checksum has one byte: of the frames with several damaged bytes, one in 256 is accepted.
        frames = [message.header.frame_id for message in host.messages["imu_data"]]
        assert frames.count("base_link") > 0.98 * len(frames)
        assert device.connected
