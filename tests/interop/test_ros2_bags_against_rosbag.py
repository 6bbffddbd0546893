"""Bags that were converted from ROS 2 recordings, read by Debian's rosbag."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin

from interop.ros1_peers import Ros1Peers
from rostether.recording.files import open_recording
from rostether.recording.reindexing import copy
from unit.recording.test_ros2_bags import foreign_bag

pytestmark = pytest.mark.ros1

# Prints the values that rospy reads, of types that it knows and of types that only the bag has.
READ = """
import json, sys, rosbag
with rosbag.Bag(sys.argv[1]) as bag:
    found = {topic: message for topic, message, t in bag}
    print(json.dumps({
        "string": found["/t0"].data,
        "stamp": [found["/t1"].stamp.secs, found["/t1"].stamp.nsecs, found["/t1"].seq],
        "frame": found["/t2"].header.frame_id,
        "wait": found["/t2"].wait.to_nsec(),
        "fingers": [[each.angle, each.name] for each in found["/t2"].fingers],
        "open": found["/t2"].OPEN,
        "types": [found[topic]._type for topic in sorted(found)],
        "known": found["/t1"]._md5sum,
    }))
"""


async def test_rospy_reads_messages_of_ros2(roscore: Ros1Peers, tmp_path: Path) -> None:
    folder, bag = tmp_path / "ros2", tmp_path / "ros1.bag"
    foreign_bag(folder, StoragePlugin.SQLITE3)
    reader = open_recording(folder)
    copy(reader, bag)
    reader.close()
    peer = await roscore.rospy(READ, str(bag))
    assert json.loads((await peer.finish()).splitlines()[-1]) == {
        "string": "grüße",
        "stamp": [7, 8, 0],
        "frame": "base",
        "wait": -999_999_995,
        "fingers": [[0.5, "left"], [-0.5, ""]],
        "open": 1,
        "types": ["std_msgs/String", "std_msgs/Header", "arm_msgs/Gripper"],
        "known": "2176decaecbce78abc3b96ef049fabed",
    }
