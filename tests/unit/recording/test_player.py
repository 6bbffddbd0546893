from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from struct import Struct
from typing import Any

import pytest

from rostether.errors import RecordingError
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.msgdef.registry import Registry
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.writer import BagWriter
from rostether.recording.player import BATCH_BYTES, Player, PlaySettings
from rostether.recording.recorded import Connection
from rostether.rostime import NS_PER_S
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from unit.recording.bags import START_NS, STRING, connection, text, write_bag


class Stage:
    """A bag of 30 messages at intervals of 10 ms, played to a node that subscribes."""

    def __init__(self, folder: Path, graph: MemoryGraph, listener: MemoryGraph) -> None:
        self.path = folder / "a.bag"
        self.written = write_bag(self.path)
        self.graph = graph
        self.listener = listener
        self.received: list[tuple[str, bytes, float]] = []

    async def listen(self, *topics: str) -> None:
        loop = asyncio.get_running_loop()
        for topic in topics:

            def take(payloads: Sequence[bytes], topic: str = topic) -> None:
                self.received.extend((topic, payload, loop.time()) for payload in payloads)

            await self.listener.subscribe(topic, ANY_MESSAGE, take)

    def player(self, **settings: Any) -> Player:
        return Player(self.graph, [BagReader(self.path)], PlaySettings(delay_s=0, **settings))

    def payloads(self, topic: str | None = None) -> list[bytes]:
        return [payload for received, payload, _ in self.received if topic in (None, received)]

    async def until_received(self, count: int) -> None:
        async with asyncio.timeout(60):
            while len(self.received) < count:
                await asyncio.sleep(0.002)


@pytest.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    network = MemoryNetwork()
    graph, listener = await network.join("/play"), await network.join("/listener")
    yield Stage(tmp_path, graph, listener)
    await graph.close()
    await listener.close()


async def test_messages_are_played_in_order_and_not_before_their_time(stage: Stage) -> None:
    await stage.listen("/a", "/b")
    began_s = asyncio.get_running_loop().time()
    await stage.player(rate=2.0).play()
    await stage.until_received(30)
    assert stage.payloads("/a") == [payload for topic, _, payload in stage.written if topic == "/a"]
    assert stage.payloads("/b") == [payload for topic, _, payload in stage.written if topic == "/b"]
    for _, payload, received_s in stage.received:
        index = int(payload.split()[-1])
        assert received_s - began_s >= index * 0.005 - 0.001


async def test_start_duration_and_topics_select_messages(stage: Stage) -> None:
    await stage.listen("/a", "/b")
    await stage.player(is_immediate=True, start_s=0.1, duration_s=0.05, topics=frozenset(["/b"])).play()
    await stage.until_received(3)
    assert stage.payloads() == [text(f"message {index}") for index in (11, 13, 15)]


async def test_prefix_and_remappings_change_the_topics(stage: Stage) -> None:
    await stage.listen("/old/c", "/old/b")
    await stage.player(is_immediate=True, prefix="/old", remappings={"/a": "/c"}).play()
    await stage.until_received(30)
    assert len(stage.payloads("/old/c")) == len(stage.payloads("/old/b")) == 15


async def test_while_paused_only_steps_are_played(stage: Stage) -> None:
    await stage.listen("/a", "/b")
    player = stage.player(rate=100.0, starts_paused=True)
    task = asyncio.create_task(player.play())
    for count in range(1, 4):
        player.step()
        await stage.until_received(count)
        await asyncio.sleep(0.03)
        assert len(stage.received) == count
    player.toggle_pause()
    await asyncio.wait_for(task, 60)
    await stage.until_received(30)
    assert sorted(stage.payloads()) == sorted(payload for _, _, payload in stage.written)


async def test_it_pauses_at_pause_topics(stage: Stage) -> None:
    await stage.listen("/a", "/b")
    player = stage.player(rate=100.0, pause_topics=frozenset(["/b"]))
    task = asyncio.create_task(player.play())
    await stage.until_received(2)
    await asyncio.sleep(0.03)
    assert player.is_paused
    assert len(stage.received) == 2
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


async def test_a_loop_starts_again(stage: Stage) -> None:
    await stage.listen("/a", "/b")
    task = asyncio.create_task(stage.player(rate=20.0, is_looping=True).play())
    await stage.until_received(70)
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task
    assert stage.payloads("/a").count(text("message 0")) >= 2


async def test_the_clock_runs_with_the_recording(stage: Stage) -> None:
    await stage.listen("/clock")
    await stage.player(clock_hz=100.0, rate=0.25).play()
    await stage.until_received(3)
    times = [
        int.from_bytes(payload[:4], "little") * 10**9 + int.from_bytes(payload[4:], "little")
        for payload in stage.payloads()
    ]
    assert times == sorted(times)
    assert START_NS <= times[0] < START_NS + 200_000_000
    assert times[-1] <= START_NS + 2_000_000_000


async def test_long_gaps_are_skipped(stage: Stage) -> None:
    writer = BagWriter(stage.path)
    number = writer.add_connection(connection("/a"))
    for hours in range(3):
        writer.write(number, START_NS + hours * 3_600_000_000_000, [text(str(hours))])
    writer.close()
    await stage.listen("/a")
    await asyncio.wait_for(stage.player(skip_empty_s=1.0).play(), 60)
    await stage.until_received(3)


async def test_two_bags_are_merged(stage: Stage, tmp_path: Path) -> None:
    await stage.listen("/a", "/b")
    write_bag(tmp_path / "b.bag")
    readers = [BagReader(stage.path), BagReader(tmp_path / "b.bag")]
    await Player(stage.graph, readers, PlaySettings(is_immediate=True, delay_s=0)).play()
    await stage.until_received(60)
    assert stage.payloads("/a")[:2] == [text("message 0")] * 2


async def test_latched_messages_from_before_the_start_are_played_first(stage: Stage, tmp_path: Path) -> None:
    path = tmp_path / "latched.bag"
    writer = BagWriter(path)
    for caller, topic, is_latching, value in (
        ("/a", "/map", True, "old"),
        ("/b", "/map", True, "of b"),
        ("/a", "/map", True, "new"),
        ("/a", "/other", True, "not wanted"),
        ("/a", "/plain", False, "not latched"),
        ("/a", "/plain", False, "the end"),
    ):
        number = writer.add_connection(Connection(topic, STRING, caller, is_latching))
        writer.write(number, START_NS + writer.message_count * NS_PER_S, [text(value)])
    writer.close()
    await stage.listen("/map", "/other", "/plain")
    settings = PlaySettings(is_immediate=True, delay_s=0, start_s=4.5, topics=frozenset({"/map", "/plain"}))
    await Player(stage.graph, [BagReader(path)], settings).play()
    await stage.until_received(3)
    assert stage.payloads() == [text("of b"), text("new"), text("the end")]


def write_frames(path: Path, caller: str | None = None) -> Codec:
    """Write a bag with two static transforms; without `caller`, each node publishes one."""
    store = TypeStore(Registry())
    codec = store.codec("tf2_msgs/TFMessage")
    message_type = store.registry.message_type("tf2_msgs/TFMessage")
    writer = BagWriter(path)
    for frame in ("lidar", "camera"):
        transform = {"header": {"frame_id": "base"}, "child_frame_id": frame}
        node = f"/{frame}" if caller is None else caller
        number = writer.add_connection(Connection("/tf_static", message_type, node, is_latching=True))
        writer.write(number, START_NS, [codec.encode({"transforms": [transform]})])
    number = writer.add_connection(Connection("/plain", STRING, "/a"))
    writer.write(number, START_NS + NS_PER_S, [text("the end")])
    writer.close()
    return codec


def frames_of(codec: Codec, payload: bytes) -> list[str]:
    return [each.child_frame_id for each in codec.decode(payload).transforms]


async def test_a_late_subscriber_receives_all_static_transforms(stage: Stage, tmp_path: Path) -> None:
    codec = write_frames(tmp_path / "frames.bag")
    reader = BagReader(tmp_path / "frames.bag")
    await Player(stage.graph, [reader], PlaySettings(is_immediate=True, delay_s=0)).play()
    await stage.listen("/tf_static")
    await stage.until_received(1)
    assert frames_of(codec, stage.payloads()[0]) == ["lidar", "camera"]


async def test_a_loop_without_messages_after_the_start_ends(stage: Stage, tmp_path: Path) -> None:
    path = tmp_path / "latched.bag"
    writer = BagWriter(path)
    for topic, is_latching, time_ns in (("/map", True, START_NS), ("/plain", False, START_NS + NS_PER_S)):
        number = writer.add_connection(Connection(topic, STRING, "/a", is_latching))
        writer.write(number, time_ns, [text("a")])
    writer.close()
    settings = PlaySettings(delay_s=0, start_s=0.5, is_looping=True, topics=frozenset({"/map"}))
    player = Player(stage.graph, [BagReader(path)], settings)
    await player.play()
    assert player.played_count == 1


async def test_the_clock_begins_at_the_start_and_not_before(stage: Stage, tmp_path: Path) -> None:
    path = tmp_path / "latched.bag"
    writer = BagWriter(path)
    number = writer.add_connection(Connection("/map", STRING, "/a", is_latching=True))
    for time_ns in (START_NS, START_NS + NS_PER_S):
        writer.write(number, time_ns, [text("a")])
    writer.close()
    await stage.listen("/clock")
    settings = PlaySettings(delay_s=0, start_s=0.9, clock_hz=100)
    await Player(stage.graph, [BagReader(path)], settings).play()
    await stage.until_received(3)
    clock_s = [Struct("<I").unpack_from(payload)[0] for payload in stage.payloads("/clock")]
    assert min(clock_s) >= START_NS // NS_PER_S


async def test_all_static_transforms_from_before_the_start_are_played(stage: Stage, tmp_path: Path) -> None:
    # ROS 2 does not record which node published a message.
    codec = write_frames(tmp_path / "frames.bag", caller="")
    await stage.listen("/tf_static")
    settings = PlaySettings(is_immediate=True, delay_s=0, start_s=0.9)
    await Player(stage.graph, [BagReader(tmp_path / "frames.bag")], settings).play()
    await stage.until_received(1)
    assert frames_of(codec, stage.payloads()[0]) == ["lidar", "camera"]


async def test_a_recording_without_messages_is_reported(stage: Stage) -> None:
    BagWriter(stage.path).close()
    with pytest.raises(RecordingError, match="no message"):
        stage.player()


@pytest.mark.parametrize(
    ("count", "queue_bytes"), [(None, [None, None]), (10, [780, 780]), (0, [1 << 30] * 2)]
)
async def test_queues_have_room_for_the_requested_messages(
    stage: Stage, monkeypatch: pytest.MonkeyPatch, count: int | None, queue_bytes: list[int | None]
) -> None:
    asked: list[int | None] = []
    advertise = stage.graph.advertise

    async def noted(topic: str, message_type: Any, **options: Any) -> Any:
        asked.append(options["queue_bytes"])
        return await advertise(topic, message_type, **options)

    monkeypatch.setattr(stage.graph, "advertise", noted)
    await stage.player(is_immediate=True, queue_messages=count).play()
    # Ten messages `message 28`, each with its length and the memory of a queued message.
    assert asked == queue_bytes


async def test_it_waits_for_the_topic_that_controls_its_rate(stage: Stage) -> None:
    await stage.listen("/a", "/b")
    control = await stage.listener.advertise("/control", STRING)
    player = stage.player(rate_control_topic="/control", rate_control_max_delay_s=0.05)
    task = asyncio.create_task(player.play())
    async with asyncio.timeout(60):
        while not player._is_held:
            await asyncio.sleep(0.002)
    held_at_ns = player.time_ns
    assert held_at_ns < player.end_ns
    await asyncio.sleep(0.1)
    assert player.time_ns == held_at_ns
    async with asyncio.timeout(60):
        while not task.done():
            control.publish_raw([text("")])
            await asyncio.sleep(0.01)
    await task
    await stage.until_received(30)


async def test_large_messages_that_are_due_together_are_sent_one_by_one(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer = BagWriter(stage.path)
    number = writer.add_connection(connection())
    for index in range(6):
        writer.write(number, START_NS + index, [text(str(index)) + bytes(BATCH_BYTES // 2)])
    writer.close()
    batches: list[int] = []
    advertise = stage.graph.advertise

    async def watched(topic: str, message_type: Any, **options: Any) -> Any:
        publisher = await advertise(topic, message_type, **options)
        publish_raw = publisher.publish_raw

        def noted(payloads: Sequence[bytes]) -> bool:
            batches.append(len(payloads))
            return publish_raw(payloads)

        monkeypatch.setattr(publisher, "publish_raw", noted)
        return publisher

    monkeypatch.setattr(stage.graph, "advertise", watched)
    await stage.player(is_immediate=True).play()
    assert batches == [2, 2, 2]
