"""Recording and playing over rclpy, with a plain rclpy node."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import yaml
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from interop_ros2.rclpy_peer import RclpyPeer
from interop_ros2.test_tools import tool

JAZZY = get_typestore(Stores.ROS2_JAZZY)


async def test_messages_of_rclpy_are_recorded_and_played_back(peer: RclpyPeer, tmp_path: Path) -> None:
    folder = tmp_path / "drive"
    await peer.ask("advertise", topic="/scan", type="sensor_msgs/msg/LaserScan", quality="sensor")
    await peer.ask("advertise", topic="/place", type="geometry_msgs/msg/PoseStamped", quality="latched")
    pose = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 1.5}}}
    await peer.ask("publish", topic="/place", messages=[pose], subscribers=0)
    recording = asyncio.ensure_future(
        tool("bag", "record", "-O", str(folder), "-l", "3", "--duration", "60", "/scan", "/scan2", "/place")
    )
    scan = {"ranges": [0.5, 7.0], "header": {"frame_id": "laser"}}
    await peer.ask("advertise", topic="/scan2", type="sensor_msgs/msg/LaserScan", quality="default")
    # The publisher may discover its subscriber before the subscriber discovers the publisher; messages are
    # then lost.
    while not recording.done():
        for topic in ("/scan", "/scan2"):
            await peer.ask("publish", topic=topic, messages=[scan], subscribers=0)
        await peer.ask("publish", topic="/place", messages=[pose], subscribers=0)
        await asyncio.sleep(0.05)
    assert "9 messages" in recording.result()

    content = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    topics = {
        each["topic_metadata"]["name"]: each["topic_metadata"]
        for each in content["topics_with_message_count"]
    }
    offers = {name: topic["offered_qos_profiles"][0] for name, topic in topics.items()}
    assert [offers[name]["reliability"] for name in ("/scan", "/scan2")] == ["best_effort", "reliable"]
    assert [offers[name]["durability"] for name in ("/scan", "/place")] == ["volatile", "transient_local"]
    assert topics["/scan"]["type_description_hash"] == JAZZY.hash_rihs01("sensor_msgs/msg/LaserScan")
    with Reader(folder) as reader:
        received: list[Any] = [
            JAZZY.deserialize_cdr(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == "/scan"
        ]
    assert [list(each.ranges) for each in received] == [scan["ranges"]] * 3
    assert {each.header.frame_id for each in received} == {"laser"}

    await peer.ask("subscribe", topic="/again", type="sensor_msgs/msg/LaserScan")
    options = ["-i", "-d", "2", "--wait-for-subscribers", "--topics", "/scan"]
    options += ["--bags", str(folder), "/scan:=/again"]
    assert await tool("bag", "play", *options) == "played 3 messages\n"
    played = await peer.ask("receive", topic="/again", count=3)
    assert [each["ranges"] for each in played] == [scan["ranges"]] * 3
