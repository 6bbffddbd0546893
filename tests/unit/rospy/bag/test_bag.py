"""`import rosbag` in scripts; tests/interop compares it with the rosbag of ROS."""

from __future__ import annotations

from pathlib import Path

from rostether.recording.files import Form, open_recording
from rostether.recording.reindexing import copy
from unit.recording.bags import write_bag
from unit.rospy.programs import printed

READ = """
import sys, rosbag, yaml
from std_msgs.msg import String
with rosbag.Bag(sys.argv[1]) as bag:
    for topic, message, t in bag.read_messages(topics='/a'):
        print(topic, message.data, isinstance(message, String), t.to_nsec())
info = yaml.safe_load(rosbag.Bag(sys.argv[1])._get_yaml_info())
print(info['messages'], [each['topic'] for each in info['topics']], info['indexed'])
bag = rosbag.Bag(sys.argv[1])
print(yaml.safe_load(str(bag)) == info, yaml.safe_load(bag._get_yaml_info('topics')) == info['topics'])
"""
UNINDEXED = """
import sys, rosbag
try:
    rosbag.Bag(sys.argv[1])
except rosbag.ROSBagUnindexedException as error:
    print(error)
with rosbag.Bag(sys.argv[1], allow_unindexed=True) as bag:
    print(bag.get_message_count(), len(list(bag.reindex())))
print(rosbag.Bag(open(sys.argv[1], 'rb')).get_message_count())
"""
BROKEN = """
import sys, rosbag
with rosbag.Bag(sys.argv[1]) as bag:
    for use in (lambda: list(bag), bag.get_type_and_topic_info, lambda: rosbag.Bag(sys.argv[1], 'a')):
        try:
            use()
        except rosbag.ROSBagException as error:
            print(error)
"""
FULL = """
import resource, sys, rosbag
from std_msgs.msg import String
bag = rosbag.Bag(sys.argv[1], 'w')
bag.write('/a', String('x' * 100000))
resource.setrlimit(resource.RLIMIT_FSIZE, (50000, 50000))
try:
    bag.flush()
except rosbag.ROSBagException as error:
    print(error)
"""


async def test_bags_and_those_of_ros2_are_read(tmp_path: Path) -> None:
    bag, folder = tmp_path / "a.bag", tmp_path / "ros2"
    written = write_bag(bag, count=6)
    reader = open_recording(bag)
    copy(reader, folder, form=Form.ROS2)
    reader.close()
    times = [time_ns for topic, time_ns, _ in written if topic == "/a"]
    expected = [
        f"/a message {number} True {time_ns}" for number, time_ns in zip((0, 2, 4), times, strict=True)
    ]
    for path in (bag, folder):
        assert await printed(READ, str(path)) == [*expected, "6 ['/a', '/b'] True", "True True"]


async def test_a_bag_that_was_not_closed(tmp_path: Path) -> None:
    bag = tmp_path / "a.bag"
    write_bag(bag, closes=False)
    assert await printed(UNINDEXED, str(bag)) == ["Unindexed bag", "30 2", "30"]


async def test_a_broken_chunk_raises_the_error_of_rosbag(tmp_path: Path) -> None:
    bag = tmp_path / "a.bag"
    write_bag(bag, compression="bz2")
    data = bag.read_bytes()
    bag.write_bytes(data.replace(b"BZh9", b"BZh0", 1))
    errors = await printed(BROKEN, str(bag))
    assert len(errors) == 3
    assert all("bz2" in each for each in errors)


async def test_a_full_disk_raises_the_error_of_rosbag(tmp_path: Path) -> None:
    (error,) = await printed(FULL, str(tmp_path / "a.bag"))
    assert "cannot write" in error


async def test_a_bag_needs_a_path() -> None:
    script = """
import rosbag
try:
    rosbag.Bag("")
except ValueError as error:
    print(error)
"""
    assert await printed(script) == ["this rosbag needs the path of a file, or a file that has a path"]
