from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rostether.dashboard import recordings as module
from rostether.dashboard.recordings import Recordings
from rostether.errors import ConfigError, InvalidNameError, RecordingError
from rostether.graph.memory_network import MemoryNetwork
from rostether.graph.ports import Graph
from rostether.graph.typed_graph import TypedGraph
from rostether.msgdef.registry import Registry
from rostether.recording.files import open_recording
from rostether.serde.store import TypeStore

TIMEOUT_S = 60.0


class Usage(NamedTuple):
    total: int
    used: int
    free: int


class Robot:
    """A graph with a node that publishes, and recordings of it."""

    def __init__(self, network: MemoryNetwork, graph: TypedGraph, folder: Path) -> None:
        self.network = network
        self.graph = graph
        self.reported: list[str] = []
        self.node: Graph | None = None
        self.recordings = Recordings(folder, self.join, self.reported.append)

    async def join(self) -> Graph:
        self.node = await self.network.join("/record")
        return self.node

    async def talk(self, topic: str, text: str) -> None:
        publisher = await self.graph.publisher(topic, "std_msgs/String", latch=True)
        publisher.publish(data=text)

    async def messages(self, count: int) -> None:
        """Wait until `count` messages were recorded."""
        async with asyncio.timeout(TIMEOUT_S):
            while (await self.recordings.state())["active"]["messages"] < count:
                await asyncio.sleep(0.01)


@pytest.fixture
async def robot(tmp_path: Path) -> AsyncIterator[Robot]:
    network = MemoryNetwork()
    graph = await network.join("/robot")
    robot = Robot(network, TypedGraph(graph, TypeStore(Registry())), tmp_path / "bags")
    yield robot
    if robot.recordings.is_active:
        await robot.recordings.stop()
    await graph.close()


def topics_of(robot: Robot, name: str) -> set[str]:
    path = robot.recordings.find(name)
    assert path is not None
    return {connection.topic for connection in open_recording(path).counts}


@pytest.mark.parametrize("form", ["bag", "mcap"])
async def test_what_is_recorded_can_be_read(robot: Robot, form: str) -> None:
    await robot.talk("/chatter", "hello")
    await robot.recordings.start((), form)
    await robot.messages(1)
    state = await robot.recordings.state()
    assert state["active"]["name"].endswith(f".{form}")
    assert state["files"] == []
    assert "/record" in robot.network.snapshot().nodes
    await robot.recordings.stop()
    state = await robot.recordings.state()
    assert state["active"] is None
    (file,) = state["files"]
    path = robot.recordings.find(file["name"])
    assert path is not None
    assert path.stat().st_size == file["bytes"]
    assert "/chatter" in topics_of(robot, file["name"])
    assert "/record" not in robot.network.snapshot().nodes
    assert len(robot.reported) == 2


async def test_chosen_topics_alone(robot: Robot) -> None:
    await robot.talk("/a", "one")
    await robot.talk("/b", "two")
    await robot.recordings.start(("a",), "bag")
    await robot.messages(1)
    await robot.recordings.stop()
    (file,) = (await robot.recordings.state())["files"]
    assert topics_of(robot, file["name"]) == {"/a"}


async def test_one_at_a_time(robot: Robot) -> None:
    with pytest.raises(ConfigError, match="nothing is being recorded"):
        await robot.recordings.stop()
    await robot.recordings.start((), "bag")
    with pytest.raises(ConfigError, match="is being recorded already"):
        await robot.recordings.start((), "bag")


async def test_requests_that_make_no_sense(robot: Robot) -> None:
    with pytest.raises(ConfigError, match="is bag or mcap, not 'exe'"):
        await robot.recordings.start((), "exe")
    with pytest.raises(ConfigError, match="at most 1000 topics"):
        await robot.recordings.start(("/a",) * 1001, "bag")
    assert not robot.recordings.is_active


async def test_the_disk_is_not_filled(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(1 << 40, 0, 1 << 30))
    with pytest.raises(ConfigError, match="only 1024 MiB are free"):
        await robot.recordings.start((), "bag")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(1 << 40, 0, 1 << 39))
    monkeypatch.setattr(module, "MAX_FOLDER_BYTES", -1)
    with pytest.raises(ConfigError, match="delete or move some"):
        await robot.recordings.start((), "bag")


async def test_a_recording_ends_at_its_largest_size(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_FILE_BYTES", 20_000)
    await robot.recordings.start((), "bag")
    publisher = await robot.graph.publisher("/chatter", "std_msgs/String")
    async with asyncio.timeout(TIMEOUT_S):
        while robot.recordings.is_active:
            publisher.publish(data="x" * 5000)
            await asyncio.sleep(0.01)
    assert len((await robot.recordings.state())["files"]) == 1


async def test_a_folder_that_cannot_be_used(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "bags").write_text("a file")
    with pytest.raises(ConfigError, match=r"cannot write .*bags: File exists; choose another name"):
        await robot.recordings.start((), "bag")
    assert (await robot.recordings.state())["files"] == []


async def test_an_invalid_topic_leaves_no_node(robot: Robot) -> None:
    with pytest.raises(InvalidNameError):
        await robot.recordings.start(("/a topic",), "bag")
    assert list(robot.network.nodes) == ["/robot"]


async def test_a_failure_is_reported(robot: Robot, tmp_path: Path) -> None:
    def fails(_: Path) -> Any:
        raise RecordingError("the disk is broken")

    robot.recordings = Recordings(tmp_path, robot.join, robot.reported.append, fails)
    with pytest.raises(RecordingError, match="the disk is broken"):
        await robot.recordings.start((), "bag")
    assert (await robot.recordings.state())["error"] == "the disk is broken"


@pytest.mark.parametrize(
    "name",
    ["../secret.bag", "secret.bag/..", "link.bag", "notes.txt", "run.bag.active", ".a.bag", "", "a\n.bag"],
)
def test_only_finished_recordings_are_found(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "bags"
    folder.mkdir()
    (tmp_path / "secret.bag").write_text("secret")
    (folder / "link.bag").symlink_to(tmp_path / "secret.bag")
    for each in ("run.bag", "my run #2 ü.bag", "run.bag.active", "notes.txt", ".a.bag", "a\n.bag"):
        (folder / each).write_text("x")

    async def join() -> Graph:
        raise AssertionError

    recordings = Recordings(folder, join, lambda _: None)
    assert recordings.find("run.bag") == folder / "run.bag"
    assert recordings.find("my run #2 ü.bag") == folder / "my run #2 ü.bag"
    assert recordings.find(name) is None


async def test_a_recording_ends_with_its_node(robot: Robot) -> None:
    await robot.talk("/chatter", "hello")
    await robot.recordings.start((), "bag")
    await robot.messages(1)
    assert robot.node is not None
    await robot.node.close()
    async with asyncio.timeout(TIMEOUT_S):
        while robot.recordings.is_active:
            await asyncio.sleep(0.01)
    state = await robot.recordings.state()
    assert "the node that records was shut down" in state["error"]
    assert "/chatter" in topics_of(robot, state["files"][0]["name"])
