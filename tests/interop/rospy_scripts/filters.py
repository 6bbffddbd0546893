"""Uses message_filters and rospkg, and prints the results."""

import sys

import message_filters
import rospkg
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String


class Source(message_filters.SimpleFilter):
    pass


def stamped(name, seconds):
    return JointState(header=Header(stamp=rospy.Time.from_sec(seconds)), name=[name])


def show(label):
    return lambda *messages: print(label, [(m.name[0], m.header.stamp.to_nsec()) for m in messages])


rospy.init_node("filters")
one, two, three = Source(), Source(), Source()
exact = message_filters.TimeSynchronizer([one, two], 3)
exact.registerCallback(show("exact"))
near = message_filters.ApproximateTimeSynchronizer([one, two, three], 5, 0.1)
near.registerCallback(show("near"))
cache = message_filters.Cache(one, 3)
cache.registerCallback(lambda message, extra: print("cache", message.name, extra), "extra")
for source, name, seconds in [
    (one, "a", 1),
    (two, "b", 1.05),
    (three, "c", 1.3),
    (two, "d", 1),
    (three, "e", 1.04),
    (one, "f", 2),
    (one, "g", 2.02),
    (one, "h", 3),
    (one, "i", 4),
    (two, "j", 2),
    (two, "k", 3),
    (three, "l", 3.09),
    (three, "m", 2.95),
    (two, "n", 4.2),
    (three, "o", 4.1),
    (two, "p", 4.05),
]:
    source.signalMessage(stamped(name, seconds))
print([message.name for message in cache.getInterval(rospy.Time(2), rospy.Time(3))])
print(cache.getElemAfterTime(rospy.Time(3)).name, cache.getElemBeforeTime(rospy.Time(3, 5)).name)
print(
    cache.getElemAfterTime(rospy.Time(9)), cache.getOldestTime(), cache.getLatestTime(), cache.getLast().name
)
arrived = message_filters.Subscriber("text", String)
received = []
arrived.registerCallback(lambda message: print("heard", message.data))
arrived.registerCallback(received.append)
publisher = rospy.Publisher("text", String, queue_size=1)
while not publisher.get_num_connections():
    rospy.sleep(0.02)
publisher.publish("hello")
while not received:
    rospy.sleep(0.02)
print(arrived.getTopic(), arrived.resolved_name)
try:
    rospkg.RosPack().get_path("nowhere")
except rospkg.ResourceNotFound as error:
    print("ResourceNotFound", error.args[0])
sys.stdout.flush()
