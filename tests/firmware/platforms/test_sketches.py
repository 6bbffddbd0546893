"""The examples that need only the client library, unchanged, on Linux and on a Cortex-M in qemu."""

from __future__ import annotations

import contextlib
import math
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

from firmware.platforms.node_harness import TIMEOUT_S, NodeHarness, node_harness
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

    def __init__(self, platform: str, library: Path, folder: Path) -> None:
        self._platform = platform
        self._library = library
        self._folder = folder

    @contextlib.asynccontextmanager
    async def sketch(self, name: str, /, **parameters: Any) -> AsyncIterator[NodeHarness]:
        """Build an example and run it with the bridge and with private parameters."""
        flag = f'-DSKETCH="{EXAMPLES / name / name}.ino"'
        source = NODE / "sketch.cpp"
        program = self._folder / name
        async with node_harness() as harness:
            for key, value in parameters.items():
                await harness.graph.set_param(f"/board/{key}", value)
            if self._platform == "linux":
                compile_program(["g++", "-O1", flag], [source], self._library, program)
                async with harness.bridge("tcp://127.0.0.1:0?name=board") as (address,):
                    folder = address.removeprefix("tcp://").partition("?")[0]
                    async with running(program, environment={"ROSSERIAL_PORT": folder}):
                        yield harness
            else:
                compile_for_cortex_m(source, self._library, program, flag)
                async with (
                    await QemuBoard.start(program) as board,
                    harness.bridge(f"{board.address}?name=board"),
                ):
                    yield harness


@pytest.fixture
def stage(platform: str, library: Path, tmp_path: Path) -> Stage:
    """The stage of the platform."""
    return Stage(platform, library, tmp_path)


async def receive(harness: NodeHarness, topic: str, type_name: str) -> Message:
    """Return the next message of a topic."""
    return await harness.graph.wait_for_message(topic, type_name, timeout_s=TIMEOUT_S)


async def test_hello_world(stage: Stage) -> None:
    async with stage.sketch("HelloWorld") as harness:
        assert (await receive(harness, "/chatter", "std_msgs/String")).data == "hello world!"


async def test_pubsub(stage: Stage) -> None:
    async with stage.sketch("pubsub") as harness:
        assert (await receive(harness, "/chatter", "std_msgs/String")).data == "hello world!"
        toggle = await harness.graph.publisher("/toggle_led", "std_msgs/Empty")
        assert await toggle.wait_for_subscriber(TIMEOUT_S)


async def test_logging(stage: Stage) -> None:
    async with stage.sketch("Logging") as harness:
        await until(lambda: harness.reporter.having("nothing works"), "the fatal log")


async def test_parameters(stage: Stage) -> None:
    async with stage.sketch("Parameters", gains=[4.0, 5.5, -6.25], period_ms=20, name="Ada") as harness:
        gains = await receive(harness, "/gains", "std_msgs/Float32MultiArray")
        assert list(gains.data) == [4.0, 5.5, -6.25]
        assert (await receive(harness, "/name", "std_msgs/String")).data == "Ada"


async def test_service_server(stage: Stage) -> None:
    async with stage.sketch("ServiceServer") as harness:
        await receive(harness, "/chatter", "std_msgs/String")
        for output in ("hello", "world"):
            answer = await harness.graph.call("/test_srv", "rosserial_arduino/Test", {"input": "say"})
            assert answer.output == output


async def test_service_client(stage: Stage) -> None:
    def answer_in_capitals(request: Message) -> dict[str, str]:
        return {"output": request.input.upper()}

    async with stage.sketch("ServiceClient") as harness:
        await harness.graph.service_server("/test_srv", "rosserial_arduino/Test", answer_in_capitals)
        async for message in harness.graph.messages("/chatter", "std_msgs/String"):
            # Empty until the service exists.
            assert message.data in ("", "HELLO WORLD!")
            if message.data:
                break


async def test_time_tf(stage: Stage) -> None:
    async with stage.sketch("TimeTF") as harness:
        async for message in harness.graph.messages("/tf", "tf/tfMessage"):
            stamp = message.transforms[0].header.stamp
            # Before the host's first answer, it is the time since the start.
            if stamp.to_ns() > 10**18:
                assert abs(harness.graph.now().to_ns() - stamp.to_ns()) < 2e9
                break


async def test_odom_drives_a_circle(stage: Stage) -> None:
    async with stage.sketch("Odom") as harness:
        positions = []
        async for message in harness.graph.messages("/tf", "tf/tfMessage"):
            transform = message.transforms[0].transform
            positions.append((transform.translation.x, transform.translation.y))
            rotation = transform.rotation
            assert math.isclose(rotation.z**2 + rotation.w**2, 1.0, abs_tol=1e-6)
            if len(positions) == 10:
                break
    radius = 0.2 / 0.36
    for x, y in positions:
        assert math.isclose(math.hypot(x, y - radius), radius, abs_tol=0.01)
    assert positions[-1] != positions[0]
