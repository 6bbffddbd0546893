"""Recordings of ROS 2 under the commands for recordings, without a graph."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import pytest

from rostether.msgdef.registry import Registry
from rostether.recording.bag_reader import BagReader
from rostether.recording.bag_writer import BagWriter
from rostether.recording.files import open_recording
from rostether.recording.recorded import Connection
from rostether.serde.store import TypeStore
from unit.cli.shell import Shell
from unit.recording.bags import IMU, START_NS, STRING, text

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


def test_converted_all_the_way_round_it_is_the_same(bag: Path, tmp_path: Path, shell: Shell) -> None:
    steps = [bag, *(tmp_path / name for name in ("a", "b.db3", "c.mcap", "d", "e.mcap", "f.bag"))]
    options = {"d": ["--storage", "sqlite3"], "e.mcap": ["--format", "ros1"]}
    for source, target in pairwise(steps):
        told = shell.output("bag", "convert", str(source), str(target), *options.get(target.name, []))
        assert told == f"{target}: 6 messages\n"
    versions = [open_recording(path).format_version for path in steps]
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
    assert "6 messages, all right" in shell.output("bag", "check", str(folder))
    expression = "topic == '/imu' and m.header.stamp.sec > 2 and m.header.stamp.nanosec == 5"
    assert shell.output("bag", "filter", str(folder), str(kept), expression) == f"{kept}: 2 of 6 messages\n"
    in_ros1 = "topic == '/imu' and m.header.stamp.secs > 2"
    shell.output("bag", "filter", str(folder), str(tmp_path / "kept.bag"), in_ros1)
    assert [each.payload for each in open_recording(kept).messages()] == [
        each.payload for each in BagReader(tmp_path / "kept.bag").messages()
    ]


def test_what_makes_no_sense_is_told(bag: Path, tmp_path: Path, shell: Shell) -> None:
    full = tmp_path / "full"
    full.mkdir()
    assert "no ROS 2 bag" in shell.failure("bag", "info", str(full))
    (full / "notes.txt").write_text("precious")
    assert "is not empty" in shell.failure("bag", "convert", str(bag), str(full))
    assert (full / "notes.txt").exists()
    db3 = str(tmp_path / "a.db3")
    assert "not compressed" in shell.failure("bag", "convert", str(bag), db3, "--compression", "lz4")
    words = ("bag", "convert", str(bag), str(tmp_path / "b.bag"), "--format", "ros2")
    assert "a .bag holds ROS 1's messages" in shell.failure(*words)
    words = ("bag", "convert", str(bag), str(tmp_path / "c"), "--format", "ros1")
    assert "is a .bag or a .mcap" in shell.failure(*words)
    (tmp_path / "other.db3").write_bytes(b"SQLite format 3\0" + bytes(84))
    assert "no recording of rosbag2, or broken" in shell.failure("bag", "info", str(tmp_path / "other.db3"))


def test_a_bag_without_its_summary_is_mended(bag: Path, tmp_path: Path, shell: Shell) -> None:
    folder = tmp_path / "drive"
    shell.output("bag", "convert", str(bag), str(folder))
    (folder / "metadata.yaml").unlink()
    assert "bag reindex" in shell("bag", "info", str(folder)).err
    assert "6 messages kept" in shell.output("bag", "reindex", str(folder))
    assert "6 messages, all right" in shell.output("bag", "check", str(folder))
    assert (tmp_path / "drive.orig" / "drive_0.mcap").exists()
