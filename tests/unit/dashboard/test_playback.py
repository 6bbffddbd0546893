from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import pytest

from rostether.dashboard.playback import Playback
from rostether.dashboard.recordings import Recordings
from rostether.errors import ConfigError, RecordingError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.recording.player import PlaySettings
from rostether.serde.store import TypeStore

TIMEOUT_S = 60.0


class Stage:
    """A folder with one recording of two messages, half a minute apart."""

    def __init__(self, folder: Path) -> None:
        self.network = MemoryNetwork()
        self.recordings = Recordings(folder, self._join, lambda _: None)
        self.playback: Playback = self.recordings.playback

    async def _join(self) -> Graph:
        return await self.network.join("/play")

    async def record(self) -> str:
        graph = TypedGraph(await self.network.join("/talker"), TypeStore(Registry()))
        publisher = await graph.publisher("/chatter", "std_msgs/String")
        await self.recordings.start(("/chatter",), "bag")
        assert await publisher.wait_for_subscriber(TIMEOUT_S)
        for text in ("one", "two"):
            publisher.publish(data=text)
        await until_async(self._recorded)
        await self.recordings.stop()
        await graph.close()
        return str((await self.recordings.state())["files"][0]["name"])

    async def _recorded(self) -> bool:
        return bool((await self.recordings.state())["active"]["messages"] == 2)


async def until_async(holds: Callable[[], object]) -> None:
    async with asyncio.timeout(TIMEOUT_S):
        while True:
            found = holds()
            if await found if asyncio.iscoroutine(found) else found:
                return
            await asyncio.sleep(0.01)


@pytest.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    stage = Stage(tmp_path)
    yield stage
    await stage.playback.stop()


async def test_a_recording_is_played_below_its_prefix(stage: Stage) -> None:
    name = await stage.record()
    listener = TypedGraph(await stage.network.join("/listener"), TypeStore(Registry()))
    messages = aiter(listener.messages("/playback/chatter", "std_msgs/String"))
    hearing = asyncio.ensure_future(anext(messages))
    await until_async(lambda: "/playback/chatter" in stage.network.snapshot().topics)
    await stage.playback.play(name, 0, 1, is_prefixed=True)
    assert (await hearing).data == "one"
    assert (await anext(messages)).data == "two"
    await until_async(lambda: not stage.playback.is_active)
    assert (await stage.recordings.state())["playing"] is None
    assert "/play" not in stage.network.snapshot().nodes


async def test_it_is_paused_and_ended(stage: Stage) -> None:
    name = await stage.record()
    with pytest.raises(ConfigError, match="nothing is being played"):
        await stage.playback.pause(is_paused=True)
    await stage.playback.start(name, PlaySettings(rate=0.5, starts_paused=True))
    state = stage.playback.state()
    assert state is not None
    assert (state["name"], state["rate"], state["paused"], state["seconds"]) == (name, 0.5, True, 0)
    await stage.playback.pause(is_paused=True)
    assert stage.playback.is_active
    # Another start replaces it, like a tap on the time line.
    await stage.playback.start(name, PlaySettings(starts_paused=True, prefix="/again"))
    await until_async(lambda: "/again/chatter" in stage.network.snapshot().topics)
    assert "/chatter" not in stage.network.snapshot().topics
    await stage.playback.stop()
    assert not stage.playback.is_active
    assert "/play" not in stage.network.snapshot().nodes


async def test_what_cannot_be_played(stage: Stage, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no recording 'other\.bag'"):
        await stage.playback.start("other.bag", PlaySettings())
    with pytest.raises(ConfigError, match=r"rate must be from 0\.1 to 10, not 0"):
        await stage.playback.start("other.bag", PlaySettings(rate=0))
    (tmp_path / "broken.bag").write_bytes(b"no bag")
    with pytest.raises(RecordingError):
        await stage.playback.start("broken.bag", PlaySettings())
    assert not stage.playback.is_active
