"""The commands for recordings with ROS 2 bags."""

from __future__ import annotations

import json
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin

from programs import running
from rostether.cli.bag.recording_files import recording_types
from rostether.errors import RecordingError
from rostether.graph.ports import Publisher
from rostether.msgdef.registry import Registry
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.writer import BagWriter
from rostether.recording.files import open_recording
from rostether.recording.recorded import Connection
from rostether.serde.store import TypeStore
from unit.cli.command_shell import LiveGraph, Shell
from unit.recording.bags import IMU, START_NS, STRING, text
from unit.recording.test_ros2_bags import JAZZY, foreign_bag

STORE = TypeStore(Registry())


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    path = tmp_path / "drive.bag"
    writer = BagWriter(path)
    imu, name = Connection("/imu", IMU, "/arm"), Connection("/name", STRING, "/arm", is_latching=True)
    for number in range(5):
        value = {"header": {"stamp": {"secs": number, "nsecs": 5}, "frame_id": "base"}}
        payload = STORE.codec("sensor_msgs/Imu").encode(value)
        writer.write(writer.add_connection(imu), START_NS + number, [payload])
    writer.write(writer.add_connection(name), START_NS, [text("arm")])
    writer.close()
    return path


def test_a_recording_is_the_same_after_conversion_through_all_formats(
    bag: Path, tmp_path: Path, shell: Shell
) -> None:
    steps = [bag, *(tmp_path / name for name in ("a", "b.db3", "c.mcap", "d", "e.mcap", "f.bag"))]
    options = {"d": ["--storage", "sqlite3"], "e.mcap": ["--format", "ros1"]}
    for source, target in pairwise(steps):
        printed = shell.output("bag", "convert", str(source), str(target), *options.get(target.name, []))
        assert printed == f"{target}: 6 messages\n"
    versions = []
    for path in steps:
        with closing(open_recording(path)) as recording:
            versions.append(recording.format_version)
    assert versions == [
        "2.0",
        "rosbag2 (version 9, mcap)",
        "rosbag2 (sqlite3)",
        "MCAP (ROS 2)",
        "rosbag2 (version 9, sqlite3)",
        "MCAP",
        "2.0",
    ]
    first, last = (
        [
            (each.connection.topic, each.connection.type.md5sum, *each[1:])
            for each in BagReader(path).messages()
        ]
        for path in (bag, tmp_path / "f.bag")
    )
    assert first == last
    assert next(each for each in BagReader(tmp_path / "f.bag").counts if each.topic == "/name").is_latching


def test_shown_checked_and_filtered(bag: Path, tmp_path: Path, shell: Shell) -> None:
    folder, kept = tmp_path / "drive", tmp_path / "kept"
    shell.output("bag", "convert", str(bag), str(folder))
    facts = json.loads(shell.output("bag", "info", "--json", str(folder)))
    assert (facts["messages"], facts["topics"][0]["type"]) == (6, "sensor_msgs/msg/Imu")
    assert facts["types"][0]["md5"].startswith("RIHS01_7d9a00ff")
    assert "6 messages, no errors" in shell.output("bag", "check", str(folder))
    expression = "topic == '/imu' and m.header.stamp.sec > 2 and m.header.stamp.nanosec == 5"
    assert shell.output("bag", "filter", str(folder), str(kept), expression) == f"{kept}: 2 of 6 messages\n"
    in_ros1 = "topic == '/imu' and m.header.stamp.secs > 2"
    shell.output("bag", "filter", str(folder), str(tmp_path / "kept.bag"), in_ros1)
    assert [each.payload for each in open_recording(kept).messages()] == [
        each.payload for each in BagReader(tmp_path / "kept.bag").messages()
    ]


def test_mistakes_are_reported(bag: Path, tmp_path: Path, shell: Shell) -> None:
    full = tmp_path / "full"
    full.mkdir()
    assert "not a ROS 2 bag" in shell.failure("bag", "info", str(full))
    (full / "notes.txt").write_text("precious")
    assert "is not empty" in shell.failure("bag", "convert", str(bag), str(full))
    assert (full / "notes.txt").exists()
    db3 = str(tmp_path / "a.db3")
    assert "cannot be compressed" in shell.failure("bag", "convert", str(bag), db3, "--compression", "lz4")
    for storage, packing in (("sqlite3", "--lz4"), ("mcap", "--bz2")):
        options = ("--format", "ros2", "--storage", storage, packing)
        assert "MCAP" in shell.failure("bag", "record", "-a", *options)
    words = ("bag", "convert", str(bag), str(tmp_path / "b.bag"), "--format", "ros2")
    assert "a .bag file can contain only ROS 1 messages" in shell.failure(*words)
    words = ("bag", "convert", str(bag), str(tmp_path / "c"), "--format", "ros1")
    assert "recording must be a .bag or .mcap" in shell.failure(*words)
    (tmp_path / "other.db3").write_bytes(b"SQLite format 3\0" + bytes(84))
    assert "not a recording of rosbag2, or is broken" in shell.failure(
        "bag", "info", str(tmp_path / "other.db3")
    )


def test_a_bag_without_its_summary_is_mended(bag: Path, tmp_path: Path, shell: Shell) -> None:
    folder = tmp_path / "drive"
    shell.output("bag", "convert", str(bag), str(folder))
    (folder / "metadata.yaml").unlink()
    assert "bag reindex" in shell("bag", "info", str(folder)).err
    assert "6 messages kept" in shell.output("bag", "reindex", str(folder))
    assert "6 messages, no errors" in shell.output("bag", "check", str(folder))
    assert (tmp_path / "drive.orig" / "drive_0.mcap").exists()


def test_types_that_only_a_recording_knows_are_played_unchanged(tmp_path: Path) -> None:
    written = foreign_bag(tmp_path / "foreign", StoragePlugin.MCAP)
    reader = open_recording(tmp_path / "foreign", is_native=True)
    types = recording_types(each.origin for each in reader.counts if each.origin is not None)
    for topic, _, payload in reader.messages():
        support = types.message(topic.type)
        assert topic.origin is not None
        assert (support.name, support.type_hash) == (topic.shown_type, JAZZY.hash_rihs01(topic.shown_type))
        assert support.converter.to_cdr(payload) == written[topic.topic]
    reader.close()


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_killed_recording_has_the_messages_before_its_end(
    graph: LiveGraph, tmp_path: Path, storage: str, shell: Shell
) -> None:
    node = graph.node("/node")
    publisher = graph.do(node.advertise("/chat", STRING))
    folder = tmp_path / "drive"
    words = ("bag", "record", "--format", "ros2", "--storage", storage, "-O", str(folder), "/chat")
    with running(*words, ROS_MASTER_URI=graph.uri) as process:
        graph.wait_until(lambda: publisher.subscriber_count == 1)
        graph.do(_publish_numbers(publisher, 20))
        graph.wait_until(lambda: _count(folder) == 20)
        process.kill()
        process.wait()
    assert _count(folder) == 20
    assert "20 messages kept" in shell.output("bag", "reindex", str(folder))
    assert "20 messages, no errors" in shell.output("bag", "check", str(folder))


@pytest.mark.parametrize("name", ["drive", "drive.mcap", "drive.db3"])
def test_skipped_messages_are_reported_once_and_counted(graph: LiveGraph, tmp_path: Path, name: str) -> None:
    publisher = graph.do(graph.node("/node").advertise("/chat", STRING))
    words = ("bag", "record", "--format", "ros2", "--limit", "4", "-O", str(tmp_path / name), "/chat")
    with running(*words, ROS_MASTER_URI=graph.uri) as process:
        graph.wait_until(lambda: publisher.subscriber_count == 1)
        graph.do(_publish(publisher, [text("good"), b"\xff\xff\xff\xff", text("better"), b"\5\0\0\0"]))
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "2 messages, " in out
    first, last = err.splitlines()
    assert first.startswith("WARNING: /chat: messages that do not fit their type are skipped: ")
    assert last == "WARNING: /chat: 2 messages do not fit their type; skipped"
    assert _count(tmp_path / name) == 2


async def _publish(publisher: Publisher, payloads: list[bytes]) -> None:
    publisher.publish_raw(payloads)


async def _publish_numbers(publisher: Publisher, count: int) -> None:
    publisher.publish_raw([text(str(number)) for number in range(count)])


def _count(folder: Path) -> int:
    try:
        reader = open_recording(folder)
    except RecordingError:
        return 0  # not begun
    with closing(reader):
        return sum(reader.counts.values())


def test_a_definition_under_msg_path_is_used(bag: Path, tmp_path: Path, shell: Shell) -> None:
    own = tmp_path / "msgs" / "arm_msgs"
    (own / "msg").mkdir(parents=True)
    (own / "package.xml").write_text(
        "<package format='3'><name>arm_msgs</name><version>1.0.0</version><description>d</description>"
        "<buildtool_depend>ament_cmake</buildtool_depend><export><build_type>ament_cmake</build_type></export>"
        "</package>"
    )
    (own / "msg" / "Grip.msg").write_text("float64 force  # in N\nuint8 mode 4\n")
    registry = Registry(bundled=False)
    registry.add_full_text("arm_msgs/Grip", "float64 force\n")
    writer = BagWriter(bag)
    number = writer.add_connection(Connection("/grip", registry.message_type("arm_msgs/Grip")))
    writer.write(number, START_NS, [bytes(8)])
    writer.close()
    shell.output("bag", "convert", str(bag), str(tmp_path / "out"), "--msg-path", str(own.parent))
    reader = open_recording(tmp_path / "out", is_native=True)
    (connection,) = reader.counts
    assert connection.origin is not None
    assert connection.origin.definition == "float64 force  # in N\nuint8 mode 4\n"
    (message,) = reader.messages()
    assert message.payload == bytes(8) + b"\4"
    reader.close()


def test_messages_that_fit_no_type_are_reported(tmp_path: Path, shell: Shell) -> None:
    bag, out = tmp_path / "a.bag", tmp_path / "out"
    writer = BagWriter(bag)
    number = writer.add_connection(Connection("/name", STRING))
    writer.write(number, START_NS, [text("good"), b"\xff\xff\xff\xff"])
    writer.close()
    result = shell("bag", "convert", str(bag), str(out))
    assert (result.code, result.out) == (0, f"{out}: 1 message\n")
    assert "1 message does not fit its type" in result.err
    assert "1 message, no errors" in shell.output("bag", "check", str(out))
