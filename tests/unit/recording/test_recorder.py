from __future__ import annotations

import asyncio
import contextlib
import random
import re
from collections.abc import AsyncIterator, Callable
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from rostether.errors import GraphError, RecordingError
from rostether.graph.joint_marks import MARK_TYPE, new_joint_mark
from rostether.graph.memory_network import MemoryGraph, MemoryNetwork
from rostether.graph.ports import Publisher
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.writer import BagWriter
from rostether.recording.recorded import Connection
from rostether.recording.recorder import Recorder
from rostether.recording.recording_plan import RecordLimits, TopicChoice
from rostether.rostime import NS_PER_S, Time
from unit.recording.bags import STRING, text


class Stage:
    """A graph, a node that publishes, and a recorder on it."""

    def __init__(self, folder: Path, node: MemoryGraph, recorder: MemoryGraph) -> None:
        self.folder = folder
        self.node = node
        self.recording_graph = recorder
        self.lines: list[str] = []

    def recorder(
        self,
        choice: TopicChoice,
        limits: RecordLimits | None = None,
        *,
        create: Callable[[Path], BagWriter] = BagWriter,
        repeat_latched: bool = False,
        buffer_bytes: int | None = None,
    ) -> Recorder:
        return Recorder(
            self.recording_graph,
            choice,
            limits or RecordLimits(),
            create=create,
            name=lambda number: self.folder / f"{number}.bag",
            report=self.lines.append,
            repeat_latched=repeat_latched,
            buffer_bytes=buffer_bytes,
        )

    def payloads(self, number: int = 0) -> list[bytes]:
        reader = BagReader(self.folder / f"{number}.bag")
        assert not reader.damage
        return [message.payload for message in reader.messages()]


@pytest.fixture
async def stage(tmp_path: Path) -> AsyncIterator[Stage]:
    network = MemoryNetwork()
    node, recorder = await network.join("/node"), await network.join("/record")
    yield Stage(tmp_path, node, recorder)
    await node.close()
    await recorder.close()


async def _subscribed(*publishers: Publisher) -> None:
    async with asyncio.timeout(60):
        while not all(each.subscriber_count for each in publishers):
            await asyncio.sleep(0.005)


async def _recorded(recorder: Recorder, count: int) -> None:
    async with asyncio.timeout(60):
        while recorder.progress.message_count < count:
            await asyncio.sleep(0.005)


async def _end(task: asyncio.Task[None]) -> None:
    task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


async def test_a_named_topic_is_recorded_until_cancelled(stage: Stage) -> None:
    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(TopicChoice(names=("/a",)))
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    assert (stage.folder / "0.bag.active").exists()
    payloads = [text(str(index)) for index in range(5)]
    publisher.publish_raw(payloads)
    await _recorded(recorder, 5)
    await _end(task)
    assert stage.payloads() == payloads
    (connection,) = BagReader(stage.folder / "0.bag").counts
    assert (connection.topic, connection.type) == ("/a", STRING)
    assert not (stage.folder / "0.bag.active").exists()


async def test_a_second_recorder_of_one_file_is_refused_and_the_first_continues(stage: Stage) -> None:
    publisher = await stage.node.advertise("/a", STRING)
    first = stage.recorder(TopicChoice(names=("/a",)))
    task = asyncio.create_task(first.run())
    await _subscribed(publisher)
    publisher.publish_raw([text("1")])
    await _recorded(first, 1)
    with pytest.raises(RecordingError, match=r"0\.bag\.active is being written by another recorder"):
        await stage.recorder(TopicChoice(names=("/a",))).run()
    publisher.publish_raw([text("2")])
    await _recorded(first, 2)
    await _end(task)
    assert stage.payloads() == [text("1"), text("2")]
    again = asyncio.create_task(stage.recorder(TopicChoice(names=("/a",))).run())
    await _subscribed(publisher)
    await _end(again)
    assert stage.payloads() == []


async def test_the_file_of_a_killed_recorder_is_kept(stage: Stage) -> None:
    for number in (1, 2):
        left = BagWriter(stage.folder / "0.bag.active")
        left.write(left.add_connection(Connection("/a", STRING)), NS_PER_S, [text(f"left {number}")])
        left.flush()
        task = asyncio.create_task(stage.recorder(TopicChoice(names=("/a",))).run())
        while len(stage.lines) < 3:
            await asyncio.sleep(0.005)
        await _end(task)
        assert (
            f"0.bag.active was left by a recorder that was killed: renamed it to 0.killed-{number}.bag; "
            in (stage.lines[0])
        )
        reader = BagReader(stage.folder / f"0.killed-{number}.bag")
        assert [each.payload for each in reader.messages()] == [text(f"left {number}")]
        assert stage.payloads() == []
        stage.lines.clear()


async def test_no_chunk_has_times_before_and_after_a_reset(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(TopicChoice(names=("/a",)))
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    for count, second in enumerate((100, 101, 5, 6)):
        monkeypatch.setattr(stage.recording_graph, "now", partial(Time, second, 0))
        publisher.publish_raw([text(str(second))])
        await _recorded(recorder, count + 1)
    await _end(task)
    with closing(BagReader(stage.folder / "0.bag")) as reader:
        spans = [(chunk.start_ns // NS_PER_S, chunk.end_ns // NS_PER_S) for chunk in reader._content.chunks]
    assert len(spans) >= 2
    assert all(end < 100 or start >= 100 for start, end in spans)
    assert stage.payloads() == [text("5"), text("6"), text("100"), text("101")]


async def test_a_latched_message_waits_for_simulated_time(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    latched = await stage.node.advertise("/map", STRING, latch=True)
    latched.publish_raw([text("floor")])
    monkeypatch.setattr(stage.recording_graph, "now", Time)
    recorder = stage.recorder(TopicChoice(is_all=True))
    task = asyncio.create_task(recorder.run())
    async with asyncio.timeout(60):
        while not any("waiting for the first message on /clock" in line for line in stage.lines):
            await asyncio.sleep(0.005)
    monkeypatch.setattr(stage.recording_graph, "now", partial(Time, 5, 0))
    await _recorded(recorder, 1)
    await _end(task)
    assert stage.payloads() == [text("floor")]


async def test_a_misspelt_topic_is_reported(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.recording.recording_start.CONNECT_S", 0.0)
    await stage.node.advertise("/ultrasound", STRING)
    task = asyncio.create_task(stage.recorder(TopicChoice(names=("/ultrasonud",))).run())
    async with asyncio.timeout(60):
        while not any("did you mean /ultrasound?" in line for line in stage.lines):
            await asyncio.sleep(0.005)
    await _end(task)


async def test_all_topics_are_recorded_also_later_ones_except_excluded_ones(stage: Stage) -> None:
    first = await stage.node.advertise("/a", STRING)
    left_out = await stage.node.advertise("/camera/image", STRING)
    mark = await stage.node.advertise(new_joint_mark(), MARK_TYPE)
    recorder = stage.recorder(TopicChoice(is_all=True, exclude=re.compile("/camera")))
    task = asyncio.create_task(recorder.run())
    await _subscribed(first)
    later = await stage.node.advertise("/b", STRING)
    await _subscribed(later)
    assert not left_out.subscriber_count
    # It has no messages.
    assert not mark.subscriber_count
    first.publish_raw([text("1")])
    later.publish_raw([text("2")])
    await _recorded(recorder, 2)
    await _end(task)
    assert stage.payloads() == [text("1"), text("2")]


async def test_patterns_match_whole_names() -> None:
    choice = TopicChoice(patterns=(re.compile("/arm/.*"),))
    assert choice.includes("/arm/joint", ())
    assert not choice.includes("/left/arm/joint", ())
    assert TopicChoice(node="/driver").includes("/cmd_vel", ("/driver",))


async def test_it_ends_when_each_topic_has_enough_messages(stage: Stage) -> None:
    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(TopicChoice(names=("/a",)), RecordLimits(messages_per_topic=3))
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    publisher.publish_raw([text(str(index)) for index in range(2)])
    publisher.publish_raw([text(str(index)) for index in range(2, 9)])
    await asyncio.wait_for(task, 60)
    assert stage.payloads() == [text(str(index)) for index in range(3)]


async def test_files_split_by_size_have_all_messages_and_only_the_newest_are_kept(stage: Stage) -> None:
    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(
        TopicChoice(names=("/a",)), RecordLimits(size_bytes=8000, is_splitting=True, max_splits=3)
    )
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    payloads = [text(f"{index:04}" + "x" * 400) for index in range(60)]
    for index, payload in enumerate(payloads):
        publisher.publish_raw([payload])
        await _recorded(recorder, index + 1)
    await _end(task)
    kept = [
        number for number in range(len(recorder.progress.files)) if (stage.folder / f"{number}.bag").exists()
    ]
    found = [payload for number in kept for payload in stage.payloads(number)]
    assert kept == list(range(len(recorder.progress.files)))[-3:]
    assert found == payloads[-len(found) :]
    assert len(found) > 10


async def test_files_compressed_in_the_background_are_complete(stage: Stage) -> None:
    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(
        TopicChoice(names=("/a",)),
        RecordLimits(size_bytes=4000, is_splitting=True),
        create=partial(BagWriter, compression="bz2", chunk_bytes=2000),
        buffer_bytes=1 << 20,
    )
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    payloads = [text(f"{index:04}{random.randbytes(300).hex()}") for index in range(60)]
    for index, payload in enumerate(payloads):
        publisher.publish_raw([payload])
        await _recorded(recorder, index + 1)
        await asyncio.sleep(0.002)
    await _end(task)
    files = len(recorder.progress.files)
    assert files > 1
    assert [payload for number in range(files) for payload in stage.payloads(number)] == payloads
    assert recorder.progress.message_count == 60
    assert recorder.size_bytes == sum((stage.folder / f"{n}.bag").stat().st_size for n in range(files))


async def test_each_file_starts_with_the_latched_messages(stage: Stage) -> None:
    publisher = await stage.node.advertise("/map", STRING, latch=True)
    publisher.publish_raw([text("map")])
    recorder = stage.recorder(
        TopicChoice(names=("/map",)), RecordLimits(duration_s=0.3, is_splitting=True), repeat_latched=True
    )
    task = asyncio.create_task(recorder.run())
    async with asyncio.timeout(60):
        while len(recorder.progress.files) < 3:
            await asyncio.sleep(0.01)
    await _end(task)
    assert stage.payloads(0) == stage.payloads(1) == [text("map")]


async def test_a_full_disk_ends_the_recording_and_keeps_its_messages(stage: Stage) -> None:
    class FullSoon(BagWriter):
        def flush(self) -> None:
            if self.message_count > 4:
                raise RecordingError("cannot write x: No space left on device")
            super().flush()

        def close(self) -> None:
            super().flush()
            super().close()

    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(TopicChoice(names=("/a",)), create=FullSoon)
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    publisher.publish_raw([text(str(index)) for index in range(5)])
    with pytest.raises(
        RecordingError, match=r"No space left on device; recording stopped; .*0\.bag contains the messages"
    ):
        await asyncio.wait_for(task, 60)
    assert len(stage.payloads()) == 5
    assert recorder.progress.message_count == 5


async def test_errors_at_the_end_are_reported_even_after_ctrl_c(stage: Stage) -> None:
    recorder = stage.recorder(TopicChoice(names=("/a",)))
    publisher = await stage.node.advertise("/a", STRING)
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    (stage.folder / "0.bag.active").unlink()
    task.cancel()
    with pytest.raises(
        RecordingError,
        match=r"cannot rename .*0\.bag\.active to 0\.bag: No such file or directory; do not move",
    ):
        await asyncio.wait_for(task, 60)


async def test_a_graph_that_cannot_unsubscribe_leaves_a_complete_file(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def refuse(_: object) -> None:
        raise GraphError("the graph has ended")

    publisher = await stage.node.advertise("/a", STRING)
    recorder = stage.recorder(TopicChoice(names=("/a",)))
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    publisher.publish_raw([text("kept")])
    await _recorded(recorder, 1)
    subscriber = next(iter(recorder._subscribers.values()))
    monkeypatch.setattr(type(subscriber), "close", refuse)
    await _end(task)
    monkeypatch.undo()
    assert stage.payloads() == [text("kept")]


async def test_no_new_file_is_started_after_an_index_could_not_be_written(stage: Stage) -> None:
    class NoIndex(BagWriter):
        def close(self) -> None:
            self.flush()
            raise RecordingError("cannot write x: No space left on device")

    publisher = await stage.node.advertise("/a", STRING)
    limits = RecordLimits(size_bytes=5000, is_splitting=True)
    recorder = stage.recorder(TopicChoice(names=("/a",)), limits, create=NoIndex)
    task = asyncio.create_task(recorder.run())
    await _subscribed(publisher)
    publisher.publish_raw([bytes(5000)])
    with pytest.raises(RecordingError, match=r"device; recording stopped; `rostether bag reindex .*0\.bag`"):
        await asyncio.wait_for(task, 60)
    assert [each.name for each in stage.folder.iterdir()] == ["0.bag"]
    assert recorder.progress.message_count == 1
