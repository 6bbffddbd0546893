"""ROS 2 bags and the package rosbags: each reads the files of the other."""

from __future__ import annotations

import itertools
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rostether.errors import RecordingError
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.recording.files import Form, create_recording, form_of, open_recording
from rostether.recording.recorded import Connection, RecordedMessage
from rostether.recording.reindexing import copy, reindex, write_messages
from rostether.recording.ros2 import db3_writer
from rostether.recording.ros2.bag_writer import Ros2Bag
from rostether.recording.ros2.db3_reader import Db3Reader
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.store import TypeStore
from unit.recording.bags import START_NS, connection, text

JAZZY = get_typestore(Stores.ROS2_JAZZY)
STORE = TypeStore(Registry())
OWN_TYPE = "arm_msgs/msg/Gripper"
JAZZY.register(
    get_types_from_msg(
        "std_msgs/Header header\nbuiltin_interfaces/Duration wait\nFinger[] fingers\nuint8 OPEN=1\n", OWN_TYPE
    )
    | get_types_from_msg("float64 angle\nstring name\n", "arm_msgs/msg/Finger")
)
_INFINITE = QosTime(9223372036, 854775807)


def qos(durability: QosDurability) -> Qos:
    return Qos(
        QosHistory.KEEP_LAST,
        5,
        QosReliability.BEST_EFFORT,
        durability,
        _INFINITE,
        _INFINITE,
        QosLiveliness.AUTOMATIC,
        _INFINITE,
        False,
    )


def values() -> dict[str, Any]:
    types = JAZZY.types
    stamp = types["builtin_interfaces/msg/Time"](sec=7, nanosec=8)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="base")
    finger = types["arm_msgs/msg/Finger"]
    return {
        "std_msgs/msg/String": types["std_msgs/msg/String"]("grüße"),
        "std_msgs/msg/Header": header,
        OWN_TYPE: types[OWN_TYPE](
            header=header,
            wait=types["builtin_interfaces/msg/Duration"](sec=-1, nanosec=5),
            fingers=[finger(angle=0.5, name="left"), finger(angle=-0.5, name="")],
        ),
    }


def foreign_bag(
    folder: Path, storage: StoragePlugin, mode: CompressionMode = CompressionMode.NONE, version: Any = 9
) -> dict[str, bytes]:
    """Write one message of each type with rosbags; return their CDR by topic."""
    written = {}
    writer = Writer(folder, version=version, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        for number, (type_name, value) in enumerate(values().items()):
            topic = f"/t{number}"
            offers = [qos(QosDurability.TRANSIENT_LOCAL if number else QosDurability.VOLATILE)]
            connection = writer.add_connection(topic, type_name, typestore=JAZZY, offered_qos_profiles=offers)
            data = bytes(JAZZY.serialize_cdr(value, type_name))
            writer.write(connection, START_NS + number, data)
            written[topic] = data
    return written


def messages(path: Path, *, is_native: bool = False) -> list[RecordedMessage]:
    reader = open_recording(path, is_native=is_native)
    try:
        found = list(reader.messages())
        assert not reader.unreadable
        assert not reader.damage
        assert len(found) == sum(reader.counts.values())
        return found
    finally:
        reader.close()


def through_rosbags(path: Path) -> Iterator[tuple[str, int, str, bytes]]:
    with Reader(path) as reader:
        for connection, time_ns, data in reader.messages():
            yield connection.topic, time_ns, connection.msgtype, bytes(data)


MODES = [
    (StoragePlugin.MCAP, CompressionMode.NONE, 9),
    (StoragePlugin.MCAP, CompressionMode.STORAGE, 9),
    (StoragePlugin.MCAP, CompressionMode.MESSAGE, 9),
    (StoragePlugin.MCAP, CompressionMode.FILE, 8),
    (StoragePlugin.SQLITE3, CompressionMode.NONE, 8),
    (StoragePlugin.SQLITE3, CompressionMode.MESSAGE, 9),
    (StoragePlugin.SQLITE3, CompressionMode.FILE, 9),
]


@pytest.mark.parametrize(("storage", "mode", "version"), MODES)
def test_bags_of_rosbags_are_read(
    tmp_path: Path, storage: StoragePlugin, mode: CompressionMode, version: int
) -> None:
    folder = tmp_path / "theirs"
    foreign_bag(folder, storage, mode, version)
    string, header, own = messages(folder)
    assert string.payload == text("grüße")
    assert [each.time_ns - START_NS for each in (string, header, own)] == [0, 1, 2]
    assert header.connection.type == STORE.registry.message_type("std_msgs/Header")
    assert STORE.codec("std_msgs/Header").decode(header.payload).stamp.secs == 7
    assert (string.connection.is_latching, header.connection.is_latching) == (False, True)
    assert own.connection.shown_type == OWN_TYPE


def test_another_message_compression_is_an_error_with_the_bag(tmp_path: Path) -> None:
    folder = tmp_path / "theirs"
    foreign_bag(folder, StoragePlugin.SQLITE3, CompressionMode.MESSAGE, 9)
    metadata = folder / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("zstd", "lz4"))
    with pytest.raises(RecordingError, match=f"{folder}: the messages are compressed with 'lz4'; only zstd"):
        open_recording(folder)


def test_a_workspace_may_have_definitions_of_ros2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    definition = tmp_path / "ws/arm_msgs/msg/Gripper.msg"
    definition.parent.mkdir(parents=True)
    definition.write_text("string<=5 name\n")
    (tmp_path / "ws/arm_msgs/package.xml").write_text("<package><name>arm_msgs</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ws"))
    foreign_bag(tmp_path / "theirs", StoragePlugin.MCAP)
    assert messages(tmp_path / "theirs")[2].connection.shown_type == OWN_TYPE


def test_a_type_that_only_ros2_has_is_converted_to_ros1(tmp_path: Path) -> None:
    foreign_bag(tmp_path / "theirs", StoragePlugin.SQLITE3)
    own = messages(tmp_path / "theirs")[2]
    registry = Registry(bundled=False)
    registry.add_full_text("arm_msgs/Gripper", own.connection.type.definition)
    spec = registry.message("arm_msgs/Gripper")
    assert [str(field.type) for field in spec.fields] == ["std_msgs/Header", "duration", "arm_msgs/Finger[]"]
    decoded = TypeStore(registry).codec("arm_msgs/Gripper").decode(own.payload)
    assert decoded.header.seq == 0
    assert (decoded.header.stamp.secs, decoded.wait.secs, decoded.wait.nsecs) == (7, -1, 5)
    assert [finger.name for finger in decoded.fingers] == ["left", ""]


TARGETS = [("copy", "mcap"), ("copy", "sqlite3"), ("copy.mcap", "mcap"), ("copy.db3", "mcap")]


@pytest.mark.parametrize(("name", "storage"), TARGETS)
def test_copies_of_bags_of_rosbags_have_the_same_bytes(tmp_path: Path, name: str, storage: str) -> None:
    folder = tmp_path / "theirs"
    written = foreign_bag(folder, StoragePlugin.MCAP)
    target = tmp_path / name
    reader = open_recording(folder, is_native=True)
    assert form_of(reader) is Form.ROS2
    assert copy(reader, target, form=Form.ROS2, storage=storage) == 3
    reader.close()
    assert {topic: data for topic, _, _, data in through_rosbags(target)} == written
    with Reader(folder) as theirs, Reader(target) as ours:
        for one, other in zip(theirs.connections, ours.connections, strict=True):
            assert (one.topic, one.msgtype, one.msgcount) == (other.topic, other.msgtype, other.msgcount)
            assert one.ext == other.ext
            assert one.msgdef == other.msgdef
            assert other.digest in ("", JAZZY.hash_rihs01(one.msgtype))


@pytest.mark.parametrize(("name", "storage"), TARGETS)
def test_a_ros1_bag_is_converted_to_ros2_and_back(tmp_path: Path, name: str, storage: str) -> None:
    bag, target = tmp_path / "a.bag", tmp_path / name
    imu = STORE.codec("sensor_msgs/Imu").encode({"header": {"frame_id": "base", "stamp": {"secs": 3}}})
    with_bag = create_recording(bag)
    for caller in ("/one", "/other"):
        connection = Connection("/imu", STORE.registry.message_type("sensor_msgs/Imu"), caller)
        with_bag.write(with_bag.add_connection(connection), START_NS, [imu, imu])
    latched = Connection("/name", STORE.registry.message_type("std_msgs/String"), "/one", True)
    with_bag.write(with_bag.add_connection(latched), START_NS + 5, [text("arm")])
    with_bag.close()
    reader = open_recording(bag)
    assert copy(reader, target, form=Form.ROS2, storage=storage) == 5
    reader.close()
    found = list(through_rosbags(target))
    assert [(topic, time_ns - START_NS) for topic, time_ns, _, _ in found] == [("/imu", 0)] * 4 + [
        ("/name", 5)
    ]
    value: Any = JAZZY.deserialize_cdr(found[0][3], found[0][2])
    assert (value.header.frame_id, value.header.stamp.sec) == ("base", 3)
    assert bytes(JAZZY.serialize_cdr(value, found[0][2])) == found[0][3]
    back = messages(target)
    assert [each.payload for each in back] == [imu] * 4 + [text("arm")]
    assert [each.connection.is_latching for each in back] == [False] * 4 + [True]
    assert back[0].connection.type == STORE.registry.message_type("sensor_msgs/Imu")


def test_a_bag_of_several_files_and_one_that_was_not_closed(tmp_path: Path) -> None:
    folder = tmp_path / "drive"
    bag = Ros2Bag(folder)
    connection = Connection("/chat", STORE.registry.message_type("std_msgs/String"))
    for number in range(3):
        writer = bag.create(bag.path_of(number))
        writer.write(writer.add_connection(connection), START_NS + number, [text(str(number))])
        if number < 2:
            writer.close()
        else:
            writer.flush()
    assert [each.payload for each in messages(folder)] == [text("0"), text("1")]
    assert len(list(through_rosbags(folder))) == 2
    (folder / "metadata.yaml").unlink()
    reader = open_recording(folder)
    assert "metadata.yaml" in reader.damage
    assert [each.payload for each in reader.messages()] == [text("0"), text("1"), text("2")]
    reader.close()
    mended = reindex(folder, folder, keep_original=tmp_path / "drive.orig")
    assert mended.message_count == 3
    assert len(list(through_rosbags(folder))) == 3
    assert sorted(each.name for each in tmp_path.iterdir()) == ["drive", "drive.orig"]


def test_committed_messages_can_be_read_while_others_are_recorded(tmp_path: Path) -> None:
    path = tmp_path / "a.db3.active"
    writer = create_recording(path, form=Form.ROS2)
    number = writer.add_connection(Connection("/chat", STORE.registry.message_type("std_msgs/String")))
    for index in range(10):
        writer.write(number, START_NS + index, [text("x")])
    writer.flush()
    reader = Db3Reader(path)
    assert len(list(reader.messages())) == 10
    writer.write(number, START_NS + 10, [text("x")])
    writer.close()
    reader.close()
    assert [each.name for each in tmp_path.iterdir()] == ["a.db3.active"]
    assert len(list(through_rosbags(path.replace(tmp_path / "a.db3")))) == 11


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "its structure is not that of rosbag2"),
        ("[]", "its structure is not that of rosbag2"),
        ("rosbag2_bagfile_information:", "its structure is not that of rosbag2"),
        ("rosbag2_bagfile_information: {relative_file_paths: [[]]}", "its structure is not that of rosbag2"),
        ("a: &a [*a]", "endless as YAML"),
        ("\x00", "not YAML"),
        ("rosbag2_bagfile_information: {version: 9}", "it has no relative_file_paths"),
        (
            "rosbag2_bagfile_information: {version: x, storage_identifier: mcap, relative_file_paths: []}",
            "its structure is not that of rosbag2",
        ),
    ],
)
def test_broken_metadata_is_reported_in_one_line(tmp_path: Path, content: str, reason: str) -> None:
    (tmp_path / "metadata.yaml").write_text(content)
    with pytest.raises(RecordingError, match=rf"metadata\.yaml does not describe .*: {reason}") as raised:
        open_recording(tmp_path)
    assert "\n" not in str(raised.value)


def test_a_database_names_the_distribution_of_its_types(tmp_path: Path) -> None:
    types = Ros2Types(Registry(), Ros2Definitions(distro="humble"))
    create_recording(tmp_path / "a.db3", types=types).close()
    with closing(sqlite3.connect(tmp_path / "a.db3")) as database:
        assert database.execute("SELECT ros_distro FROM schema").fetchall() == [("humble",)]


def test_metadata_cannot_name_files_in_other_folders(tmp_path: Path) -> None:
    foreign_bag(tmp_path / "theirs", StoragePlugin.MCAP)
    bag = tmp_path / "bag"
    bag.mkdir()
    summary = (tmp_path / "theirs" / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(summary.replace("theirs.mcap", "../theirs/theirs.mcap"))
    with pytest.raises(RecordingError, match=r"bag/theirs\.mcap: No such file"):
        open_recording(bag)


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_truncated_files_yield_their_complete_messages_or_one_line(
    tmp_path: Path, storage: StoragePlugin
) -> None:
    foreign_bag(tmp_path / "theirs", storage)
    (path,) = (each for each in (tmp_path / "theirs").iterdir() if each.suffix != ".yaml")
    data = path.read_bytes()
    cut = tmp_path / f"cut{path.suffix}"
    for size, at in itertools.product(range(0, len(data), max(len(data) // 10, 1)), (None, 0xFF)):
        cut.write_bytes(data[:size] if at is None else data[:size] + bytes([at]) * 40 + data[size + 40 :])
        try:
            reader = open_recording(cut)
        except RecordingError as error:
            assert "\n" not in str(error)
            continue
        try:
            assert len(list(reader.messages())) <= 3
        except RecordingError as error:
            assert "\n" not in str(error)
        finally:
            reader.close()


@pytest.mark.parametrize("table", ["messages", "topics"])
def test_an_endless_view_is_not_run(tmp_path: Path, table: str) -> None:
    path = tmp_path / "a.db3"
    create_recording(path, form=Form.ROS2).close()
    endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT"
    columns = {
        "messages": "i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data FROM n",
        "topics": "i AS id, '/a' AS name, 'a/msg/B' AS type, 'cdr' AS serialization_format FROM n",
    }
    with sqlite3.connect(path) as database:
        database.execute(f"DROP TABLE {table}")
        database.execute(f"CREATE VIEW {table} AS {endless} {columns[table]}")
    database.close()
    with pytest.raises(RecordingError, match="no tables of topics and messages"):
        open_recording(path)


def test_endless_aliases_are_not_written_out(tmp_path: Path) -> None:
    bomb = "\n".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12))
    rest = (
        "rosbag2_bagfile_information: {version: 9, storage_identifier: *a11, relative_file_paths: [a.mcap],"
    )
    summary = f"a0: &a0 [x]\n{bomb}\n{rest} topics_with_message_count: []}}\n"
    (tmp_path / "metadata.yaml").write_text(summary)
    with pytest.raises(RecordingError, match="too large as YAML"):
        open_recording(tmp_path)


def test_the_mcap_package_reads_own_ros2_files(tmp_path: Path) -> None:
    folder = tmp_path / "theirs"
    written = foreign_bag(folder, StoragePlugin.SQLITE3)
    reader = open_recording(folder, is_native=True)
    copy(reader, tmp_path / "ours.mcap", form=Form.ROS2)
    reader.close()
    with (tmp_path / "ours.mcap").open("rb") as file:
        mcap = make_reader(file, validate_crcs=True)
        assert mcap.get_header().profile == "ros2"
        found = list(mcap.iter_messages())
    assert {channel.topic: message.data for _, channel, message in found} == written
    for schema, channel, _ in found:
        assert schema is not None
        assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
        assert channel.metadata["topic_type_hash"] == JAZZY.hash_rihs01(schema.name)
        assert "durability: " in channel.metadata["offered_qos_profiles"]


@pytest.mark.parametrize(("name", "storage"), TARGETS)
def test_a_copy_that_fails_leaves_no_file(tmp_path: Path, name: str, storage: str) -> None:
    def failing() -> Iterator[RecordedMessage]:
        yield RecordedMessage(Connection("/chat", chat), START_NS, text("x" * (2 << 20)))
        raise RecordingError("the disk is full")

    chat = STORE.registry.message_type("std_msgs/String")
    with pytest.raises(RecordingError, match="the disk is full"):
        write_messages(failing(), tmp_path / name, partial(create_recording, form=Form.ROS2, storage=storage))
    assert list(tmp_path.iterdir()) == []


def test_a_database_without_space_for_its_tables_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(db3_writer, "_TABLES", "CREATE TABLE a(b); CREATE TABLE a(b);")
    with pytest.raises(RecordingError, match=r"cannot write .*a\.db3"):
        create_recording(tmp_path / "a.db3", form=Form.ROS2)
    assert list(tmp_path.iterdir()) == []


def test_a_database_whose_path_is_too_long_for_sqlite_is_reported(tmp_path: Path) -> None:
    folder = tmp_path.joinpath(*["d" * 200] * 3)
    folder.mkdir(parents=True)
    with pytest.raises(RecordingError, match=r"cannot write .*a\.db3"):
        create_recording(folder / "a.db3", form=Form.ROS2)
    assert list(folder.iterdir()) == []


def test_a_damaged_time_in_the_index_of_a_database_hides_only_its_message(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    with closing(create_recording(path, form=Form.ROS2)) as writer:
        number = writer.add_connection(connection())
        for index in range(9):
            writer.write(number, START_NS + index, [text(f"message {index}")])
    data = path.read_bytes()
    # The header of an entry (3 bytes, a time of 8 bytes, a row's number of 1 byte), and the time.
    entry = b"\x03\x06\x01" + (START_NS + 4).to_bytes(8, "big")
    assert data.count(entry) == 1
    # The time becomes a text, which comes after all times.
    path.write_bytes(data.replace(entry, b"\x03\x1d\x01" + entry[3:]))
    with closing(open_recording(path)) as reader:
        assert [each.time_ns - START_NS for each in reader.messages()] == [0, 1, 2, 3, 5, 6, 7, 8]
