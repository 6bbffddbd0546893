"""The examples that need only the client library, unchanged, on Linux and on a Cortex-M in qemu."""

from __future__ import annotations

import contextlib
import math
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from firmware.platforms.meeting import TIMEOUT_S, Meeting, meeting
from firmware.platforms.programs import EXAMPLES, NODE, compile_for_cortex_m, compile_program, running
from rostether.serde.values import Message
from rostether.simulation.qemu import QemuBoard
from waiting import until

PLATFORMS = [
    pytest.param("linux", marks=pytest.mark.gcc),
    pytest.param("cortex-m", marks=[pytest.mark.arm, pytest.mark.qemu]),
]


@pytest.fixture(params=PLATFORMS)
def platform(request: pytest.FixtureRequest) -> str:
    """The platform of the sketch."""
    name: str = request.param
    return name


class Stage:
    """Runs sketches on one platform."""

    def __init__(self, platform: str, library: Path, place: Path) -> None:
        self._platform = platform
        self._library = library
        self._place = place

    @contextlib.asynccontextmanager
    async def sketch(self, name: str, /, **parameters: Any) -> AsyncIterator[Meeting]:
        """Build an example and run it with the bridge and with private parameters."""
        flag = f'-DSKETCH="{EXAMPLES / name / name}.ino"'
        source = NODE / "sketch.cpp"
        program = self._place / name
        async with meeting() as met:
            for key, value in parameters.items():
                await met.graph.set_param(f"/board/{key}", value)
            if self._platform == "linux":
                compile_program(["g++", "-O1", flag], [source], self._library, program)
                async with met.bridge("tcp://127.0.0.1:0?name=board") as (address,):
                    place = address.removeprefix("tcp://").partition("?")[0]
                    async with running(program, environment={"ROSSERIAL_PORT": place}):
                        yield met
            else:
                compile_for_cortex_m(source, self._library, program, flag)
                async with await QemuBoard.start(program) as board, met.bridge(f"{board.address}?name=board"):
                    yield met


@pytest.fixture
def stage(platform: str, library: Path, tmp_path: Path) -> Stage:
    """The stage of the platform."""
    return Stage(platform, library, tmp_path)


async def receive(met: Meeting, topic: str, type_name: str) -> Message:
    """Return the next message of a topic."""
    return await met.graph.wait_for_message(topic, type_name, timeout_s=TIMEOUT_S)


async def test_hello_world(stage: Stage) -> None:
    async with stage.sketch("HelloWorld") as met:
        assert (await receive(met, "/chatter", "std_msgs/String")).data == "hello world!"


async def test_pubsub(stage: Stage) -> None:
    async with stage.sketch("pubsub") as met:
        assert (await receive(met, "/chatter", "std_msgs/String")).data == "hello world!"
        toggle = await met.graph.publisher("/toggle_led", "std_msgs/Empty")
        assert await toggle.wait_for_subscriber(TIMEOUT_S)


async def test_logging(stage: Stage) -> None:
    async with stage.sketch("Logging") as met:
        await until(lambda: met.reporter.having("nothing works"), "the fatal log")


async def test_parameters(stage: Stage) -> None:
    async with stage.sketch("Parameters", gains=[4.0, 5.5, -6.25], period_ms=20, name="Ada") as met:
        gains = await receive(met, "/gains", "std_msgs/Float32MultiArray")
        assert list(gains.data) == [4.0, 5.5, -6.25]
        assert (await receive(met, "/name", "std_msgs/String")).data == "Ada"


async def test_service_server(stage: Stage) -> None:
    async with stage.sketch("ServiceServer") as met:
        await receive(met, "/chatter", "std_msgs/String")
        for output in ("hello", "world"):
            answer = await met.graph.call("/test_srv", "rosserial_arduino/Test", {"input": "say"})
            assert answer.output == output


async def test_service_client(stage: Stage) -> None:
    def shout(request: Message) -> dict[str, str]:
        return {"output": request.input.upper()}

    async with stage.sketch("ServiceClient") as met:
        await met.graph.service_server("/test_srv", "rosserial_arduino/Test", shout)
        async for message in met.graph.messages("/chatter", "std_msgs/String"):
            # Empty until the service exists.
            assert message.data in ("", "HELLO WORLD!")
            if message.data:
                break


async def test_time_tf(stage: Stage) -> None:
    async with stage.sketch("TimeTF") as met:
        async for message in met.graph.messages("/tf", "tf/tfMessage"):
            stamp = message.transforms[0].header.stamp
            # Before the host's first answer, it is the time since the start.
            if stamp.to_ns() > 10**18:
                assert abs(met.graph.now().to_ns() - stamp.to_ns()) < 2e9
                break


async def test_odom_drives_a_circle(stage: Stage) -> None:
    async with stage.sketch("Odom") as met:
        places = []
        async for message in met.graph.messages("/tf", "tf/tfMessage"):
            transform = message.transforms[0].transform
            places.append((transform.translation.x, transform.translation.y))
            rotation = transform.rotation
            assert math.isclose(rotation.z**2 + rotation.w**2, 1.0, abs_tol=1e-6)
            if len(places) == 10:
                break
    radius = 0.2 / 0.36
    for x, y in places:
        assert math.isclose(math.hypot(x, y - radius), radius, abs_tol=0.01)
    assert places[-1] != places[0]
