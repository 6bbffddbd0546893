"""Prints, as JSON, what a node of rospy receives from another node and from the master about it."""

# Written as users write their nodes.
# ruff: noqa: B023, PIE810

import json
import sys
import time

import rosgraph
import rospy
from std_msgs.msg import Int32
from std_srvs.srv import SetBool, Trigger

node = sys.argv[1]
rospy.init_node("observer")
master = rosgraph.Master("/observer")
found = {}


def wait_until(condition, what):
    end = time.time() + 60
    while not condition():
        assert time.time() < end, "no " + what
        time.sleep(0.02)


def registered():
    publishers, subscribers, services = master.getSystemState()
    return [
        sorted(name for name, nodes in kind if node in nodes) for kind in (publishers, subscribers, services)
    ]


wait_until(lambda: rospy.has_param(node + "/ready"), "node")
wait_until(lambda: len(registered()[2]) >= 4, "services")
found["registered"] = registered()
found["types"] = sorted(pair for pair in master.getTopicTypes() if pair[0] in found["registered"][0])
found["parameters"] = rospy.get_param(node)
for topic in found["registered"][0]:
    seen = []

    def store(message, seen=seen):
        if message._connection_header["callerid"] == node:
            seen.append(message)

    subscriber = rospy.Subscriber(topic, rospy.AnyMsg, store)
    if topic.endswith("/echo"):
        ask = rospy.Publisher(topic.replace("echo", "ask"), Int32, queue_size=1)
        wait_until(lambda: ask.get_num_connections() and subscriber.get_num_connections(), "asked")
        # Repeatedly, because rospy's publisher may not know a connected subscriber yet.
        wait_until(lambda: seen or ask.publish(41), "answer")
    wait_until(lambda: len(seen) >= 1, "message of " + topic)
    header = seen[0]._connection_header
    payload = seen[0]._buff
    if header["type"] == "rosgraph_msgs/Log":
        from rosgraph_msgs.msg import Log

        log = Log().deserialize(payload)
        payload = repr((log.level, log.name, log.msg, log.file, log.line, log.function, sorted(log.topics)))
        payload = payload.encode()
    elif header["type"] == "sensor_msgs/JointState":
        payload = payload[4:]
    found[topic] = {
        "payload": payload.decode("latin-1"),
        **{key: header[key] for key in ("callerid", "type", "md5sum", "topic", "latching")},
    }
    subscriber.unregister()


def call(name, service_class, *arguments):
    try:
        return str(rospy.ServiceProxy(name, service_class)(*arguments))
    except rospy.ServiceException as error:
        return str(error)


answer = next(name for name in found["registered"][2] if name.endswith("answer") or name.endswith("renamed"))
found["calls"] = [call(answer, SetBool, True), call(answer, SetBool, False), call(node + "/refuse", Trigger)]
print("FOUND " + json.dumps(found, sort_keys=True))
last = []


def has_last_message():
    return any(payload.endswith(b"bye") for payload in last)


early = next(topic for topic in found["registered"][0] if topic.endswith("early") or topic.endswith("moved"))
rospy.Subscriber(early, rospy.AnyMsg, lambda message: last.append(message._buff))
wait_until(lambda: last, "more messages")
print("READY")
sys.stdout.flush()
wait_until(lambda: not any(registered()), "end of the registrations")
end = time.time() + 10
while not has_last_message() and time.time() < end:
    time.sleep(0.02)
rospy.delete_param(node)  # the next talker must set its own
print("LEFT with a message" if has_last_message() else "LEFT without a message")
