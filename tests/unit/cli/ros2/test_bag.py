"""`rostether bag` on a ROS 2 graph, and with recordings of ROS 2."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml

from rostether.graph.ports import Publisher
from rostether.recording.bag.reader import BagReader
from rostether.recording.files import open_recording
from unit.cli.command_shell import LiveGraph, Shell
from unit.cli.ros2.zenoh_world import STORE, ZenohWorld

pytestmark = pytest.mark.slow

IMU_HASH = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"


def test_recorded_as_ros2_and_played_again(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    folder = tmp_path / "drive"
    for seconds in ("2", "20", "60"):
        recording = ("bag", "record", "-O", str(folder), "-l", "3", "--duration", seconds)
        printed = shell.output(*recording, "--topics", "/imu", "/name")
        content = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
        counts = [each["message_count"] for each in content["topics_with_message_count"]]
        if sum(counts) == 4:
            break
        # On a busy machine, not every publisher connects in time.
        shutil.rmtree(folder)
    assert f"Recording to {folder}/drive_0.mcap" in printed
    assert (content["version"], content["storage_identifier"]) == (9, "mcap")
    topics = {each["topic_metadata"]["name"]: each for each in content["topics_with_message_count"]}
    assert topics["/imu"]["message_count"] == 3
    assert topics["/imu"]["topic_metadata"]["type_description_hash"] == IMU_HASH
    assert topics["/name"]["topic_metadata"]["offered_qos_profiles"][0]["durability"] == "transient_local"
    reader = open_recording(folder)
    imu = next(each for each in reader.messages() if each.connection.topic == "/imu")
    decoded = STORE.codec("sensor_msgs/Imu").decode(imu.payload)
    assert (decoded.header.frame_id, decoded.angular_velocity.z) == ("base", 0.5)
    reader.close()

    received: list[bytes] = []
    clocks: list[bytes] = []
    node = world.do(world.session.join("/listener"))
    try:
        imu_type = STORE.registry.message_type("sensor_msgs/Imu")
        world.do(node.subscribe("/again", imu_type, received.extend))
        clock_type = STORE.registry.message_type("rosgraph_msgs/Clock")
        world.do(node.subscribe("/clock", clock_type, clocks.extend))
        words = [
            "-i",
            "--clock",
            "--wait-for-subscribers",
            "--topics",
            "/imu",
            "--start-offset",
            "0",
            "--playback-duration",
            "100",
            "--remap",
            "/imu:=/again",
            str(folder),
        ]
        # The options have the spellings of ros2 bag.
        assert shell.output("bag", "play", *words) == "played 3 messages\n"
        world.wait_until(lambda: len(received) == 3 and bool(clocks))
    finally:
        world.do(node.close())
    assert set(received) == {imu.payload}


def test_recorded_as_ros1(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    bag = tmp_path / "drive.bag"
    shell.output("bag", "record", "-O", str(bag), "-l", "2", "/imu")
    (connection,) = BagReader(bag).counts
    assert connection.type.md5sum == STORE.registry.message_type("sensor_msgs/Imu").md5sum
    received: list[bytes] = []
    node = world.do(world.session.join("/listener"))
    try:
        imu_type = STORE.registry.message_type("sensor_msgs/Imu")
        world.do(node.subscribe("/from_bag", imu_type, received.extend))
        shell.output("bag", "play", "-i", "--wait-for-subscribers", str(bag), "/imu:=/from_bag")
        world.wait_until(lambda: len(received) == 2)
    finally:
        world.do(node.close())
    assert received == [each.payload for each in BagReader(bag).messages()]


def test_all_is_without_hidden_topics(world: ZenohWorld, shell: Shell, tmp_path: Path) -> None:
    mcap = tmp_path / "all.mcap"
    for seconds in ("1", "10", "60"):
        mcap.unlink(missing_ok=True)
        shell.output("bag", "record", "-a", "-O", str(mcap), "--duration", seconds)
        reader = open_recording(mcap, is_native=True)
        topics = {each.topic for each in reader.counts}
        if {"/imu", "/name"} <= topics:
            break
        reader.close()
    assert reader.format_version == "MCAP (ROS 2)"
    assert {"/imu", "/name"} <= topics
    assert "/_raw" not in topics
    assert not reader.unreadable
    assert "sensor_msgs/msg/Imu" in shell.output("bag", "info", str(mcap))


def test_both_graphs_into_one_bag(world: ZenohWorld, graph: LiveGraph, shell: Shell, tmp_path: Path) -> None:
    node = graph.node("/talker")
    string = STORE.registry.message_type("std_msgs/String")
    publisher = graph.do(node.advertise("/chat", string, latch=True))
    graph.do(_said(publisher))
    bag = tmp_path / "both.bag"
    shell.output("bag", "record", "--ros1", "--ros2", "zenoh", "-O", str(bag), "-l", "1", "/imu", "/chat")
    found = {each.connection.topic: each for each in BagReader(bag).messages()}
    assert set(found) == {"/imu", "/chat"}
    assert STORE.codec("std_msgs/String").decode(found["/chat"].payload).data == "hello"
    assert found["/chat"].connection.caller_id == "/talker"
    assert found["/imu"].connection.type.md5sum == STORE.registry.message_type("sensor_msgs/Imu").md5sum


async def _said(publisher: Publisher) -> None:
    publisher.publish_raw([STORE.codec("std_msgs/String").encode({"data": "hello"})])
