"""Records the messages of a robot's nodes with Debian's rospy: each message as a line of JSON."""

import json
import sys
import threading

import rospy
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

lock = threading.Lock()


def report(record):
    with lock:
        print(json.dumps(record), flush=True)


def tf(message, topic):
    transforms = []
    for each in message.transforms:
        translation, rotation = each.transform.translation, each.transform.rotation
        transforms.append(
            [
                each.header.frame_id,
                each.child_frame_id,
                each.header.stamp.to_nsec(),
                [translation.x, translation.y, translation.z],
                [rotation.x, rotation.y, rotation.z, rotation.w],
            ]
        )
    report({"topic": topic, "node": message._connection_header["callerid"], "transforms": transforms})


def joints(message):
    report(
        {
            "topic": "joint_states",
            "node": message._connection_header["callerid"],
            "name": list(message.name),
            "position": list(message.position),
            "velocity": list(message.velocity),
            "effort": list(message.effort),
        }
    )


rospy.init_node("recorder", disable_signals=True)
for topic in ("/tf", "/tf_static"):
    rospy.Subscriber(topic, TFMessage, tf, callback_args=topic)
rospy.Subscriber("/joint_states_out", JointState, joints)
states = rospy.Publisher(sys.argv[1], JointState, queue_size=100)
report({"ready": True})
for line in sys.stdin:
    command = json.loads(line)
    if "wait_for" in command:
        while states.get_num_connections() < command["wait_for"]:
            rospy.sleep(0.02)
        report({"connected": True})
        continue
    message = JointState(name=command["name"], position=command["position"])
    message.header.stamp = rospy.Time(*divmod(command["stamp_ns"], 10**9))
    states.publish(message)
