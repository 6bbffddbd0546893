"""Uses rosbag: writes a bag, reads it and an existing one, and prints the results."""

import sys

import genpy
import rosbag
import rospy
from geometry_msgs.msg import Pose
from rosbag.bag import BagMessage
from sensor_msgs.msg import Imu
from std_msgs.msg import String


def attempt(work):
    try:
        print(work())
    except (rosbag.ROSBagException, ValueError, OSError) as error:
        print([isinstance(error, each) for each in (rosbag.ROSBagException, ValueError, OSError)])


path, other_path = sys.argv[1:]
with rosbag.Bag(path, "w", compression="bz2", chunk_threshold=400) as bag:
    bag.write("/pose", Pose(), genpy.Time(99))
    header = {"callerid": "/me", "latching": "1", "topic": "/name", "type": String._type}
    header.update(md5sum=String._md5sum, message_definition=String._full_text)
    bag.write("/name", String("arm"), genpy.Time(99), connection_header=header)
    for number in range(30):
        stamp = rospy.Time(100, number * 1000000)
        bag.write("/chat", String(data=f"hello {number}"), stamp)
        imu = Imu()
        imu.header.stamp = stamp
        imu.header.frame_id = "base"
        imu.orientation_covariance[0] = number
        bag.write("/imu", imu, t=stamp)
    bag.flush()
    print(bag.mode, bag.filename == path, bag.compression, bag.chunk_threshold, bag.version)

bag = rosbag.Bag(path)
for topic, message, t in bag:
    print(topic, t.secs, t.nsecs, message._type)
for topic, message, t in bag.read_messages(topics=["/chat", "/none"], start_time=rospy.Time(100, 27000000)):
    print(topic, message.data, t == genpy.Time(100, 27000000))
for each in bag.read_messages("/imu", end_time=rospy.Time.from_sec(100.001)):
    print(isinstance(each, BagMessage), each.message.header.stamp, each.message, each.timestamp.to_sec())
for topic, message, t in bag.read_messages(topics="/pose", raw=True):
    print(topic, message[0], message[1], message[2], message[4]._type, t)
for topic, _message, _t, header in bag.read_messages(return_connection_header=True):
    if topic == "/name":
        print(header["callerid"], header["latching"], header["type"], header["topic"], header["md5sum"])
chosen = bag.read_messages(
    connection_filter=lambda topic, datatype, md5sum, msg_def, header: datatype == "geometry_msgs/Pose"
)
print([each.topic for each in chosen])
print(bag.get_message_count(), bag.get_message_count("/chat"), bag.get_message_count(["/chat", "/pose"]))
print(f"{bag.get_start_time():.3f} {bag.get_end_time():.3f}")
info = bag.get_type_and_topic_info()
print(sorted(info.msg_types.items()))
for name, topic in sorted(info.topics.items()):
    print(name, topic.msg_type, topic.message_count, topic.connections, f"{topic.frequency or 0:.3f}")
print(sorted(bag.get_type_and_topic_info(topic_filters=["/chat"]).topics))
print(sorted(bag.get_type_and_topic_info()[1].keys()))
print(bag.get_compression_info().compression)
bag.close()
attempt(lambda: bag.get_message_count())
attempt(lambda: next(bag.read_messages()))
attempt(lambda: rosbag.Bag(path, "x"))
attempt(lambda: rosbag.Bag("/nowhere/a.bag"))
attempt(lambda: rosbag.Bag(path).write("/chat", String("x")))
attempt(lambda: rosbag.Bag(sys.argv[0]))

with rosbag.Bag(path, "a") as bag:
    bag.write("/chat", String("appended"), genpy.Time(200))
with rosbag.Bag(path) as bag:
    print(bag.get_message_count(), [message.data for _, message, _ in bag.read_messages("/chat")][-2:])

with rosbag.Bag(path + ".out", "w") as out:
    for topic, raw, t in rosbag.Bag(other_path).read_messages(raw=True):
        out.write(topic + "_again", raw, t, raw=True)
for topic, message, t in rosbag.Bag(path + ".out"):
    print(topic, message, t)
with rosbag.Bag(path, "w") as empty:
    pass
with rosbag.Bag(path) as empty:
    print(list(empty.read_messages()), empty.get_message_count(), empty.get_type_and_topic_info())
    attempt(empty.get_start_time)
