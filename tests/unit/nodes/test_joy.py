from __future__ import annotations

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from msgspec.structs import replace

from rostether.errors import ConfigError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Level
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.nodes import joy
from rostether.nodes.joy import JoySettings, device_named, publish_joystick
from rostether.serde.store import TypeStore
from rostether.serde.values import Message
from unit.nodes.test_joystick import event
from waiting import until

STORE = TypeStore(Registry())


class Stage:
    """A joy node that reads a pipe instead of the device."""

    def __init__(self, device: Path) -> None:
        self.device = device
        self.lines: list[str] = []
        self.messages: list[Message] = []
        os.mkfifo(device)
        # Opened for reading and writing: neither side waits for the other, and the test's close ends it.
        self.writer = os.open(device, os.O_RDWR)

    @asynccontextmanager
    async def publishing(self, settings: JoySettings) -> AsyncIterator[None]:
        network = MemoryNetwork()
        node, listener = [TypedGraph(await network.join(name), STORE) for name in ("/joy_node", "/listener")]

        def report(_: Level, text: str) -> None:
            self.lines.append(text)

        async def listen() -> None:
            async for message in listener.messages("/joy", "sensor_msgs/Joy"):
                self.messages.append(message)

        listening = asyncio.ensure_future(listen())
        await until(lambda: "/joy" in network.snapshot().topics)
        settings = replace(settings, device=str(self.device))
        running = asyncio.ensure_future(publish_joystick(node, settings, report))
        try:
            await until(lambda: self.lines)
            yield
        finally:
            for task in (running, listening):
                task.cancel()
            await asyncio.wait([running, listening])

    def send(self, data: bytes) -> None:
        os.write(self.writer, data)


@pytest.fixture
def stage(tmp_path: Path) -> Iterator[Stage]:
    stage = Stage(tmp_path / "js0")
    yield stage
    with contextlib.suppress(OSError):
        os.close(stage.writer)


async def test_a_button_is_published_at_once(stage: Stage) -> None:
    async with stage.publishing(JoySettings(coalesce_interval_s=60.0)):
        assert stage.lines == [f"Opened joystick: {stage.device}"]
        stage.send(event(1, 1, 1))
        await until(lambda: stage.messages)
    (message,) = stage.messages
    assert (list(message.axes), list(message.buttons)) == ([], [0, 1])
    assert (message.header.seq, message.header.frame_id) == (1, str(stage.device))
    assert message.header.stamp.secs > 0


async def test_axes_that_move_together_are_one_message(stage: Stage) -> None:
    async with stage.publishing(JoySettings(deadzone=0.0, coalesce_interval_s=0.05)):
        stage.send(event(2, 0, 32767))
        stage.send(event(2, 1, -32767))
        await until(lambda: stage.messages)
        stage.send(event(1, 0, 1))
        await until(lambda: len(stage.messages) == 2)
    assert list(stage.messages[0].axes) == [-1.0, 1.0]


async def test_it_repeats_messages_on_request(stage: Stage) -> None:
    async with stage.publishing(JoySettings(autorepeat_rate_hz=100.0)):
        await until(lambda: len(stage.messages) >= 3)
        assert [each.header.seq for each in stage.messages[:3]] == [1, 2, 3]


async def test_a_joystick_may_be_plugged_in_later_and_unplugged(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joy, "_RETRY_S", 0.01)
    away = stage.device.with_name("away")
    stage.device.rename(away)
    async with stage.publishing(JoySettings()):
        assert "no joystick at" in stage.lines[0]
        away.rename(stage.device)
        await until(lambda: len(stage.lines) == 2)
        stage.send(event(1, 0, 1))
        stage.send(event(2, 0, -32767))
        await until(lambda: bool(stage.messages) and list(stage.messages[-1].axes) == [1.0])
        stage.device.unlink()
        os.close(stage.writer)
        await until(lambda: len(stage.lines) == 3)
        await until(lambda: not any(stage.messages[-1].buttons))
    assert list(stage.messages[-1].axes) == [0.0]
    assert stage.lines[2].endswith("was disconnected; waiting for it")


async def test_invalid_settings_are_refused(stage: Stage) -> None:
    with pytest.raises(ConfigError, match="must not be below 0"):
        JoySettings(autorepeat_rate_hz=-1.0).checked()


def test_another_file_than_a_joystick_has_no_name(tmp_path: Path) -> None:
    (tmp_path / "js0").write_bytes(b"")
    assert device_named("Gamepad", tmp_path) is None
