"""Debian's tf2 buffer with lines of JSON: each line of input is an operation, each line of output an
answer.
"""

import json
import sys

import rospy
import tf2_py
from geometry_msgs.msg import TransformStamped


def as_time(ns):
    return rospy.Time(*divmod(ns, 10**9))


def set_transform(parent, child, stamp_ns, translation, rotation, is_static):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = parent, child
    message.header.stamp = as_time(stamp_ns)
    position, orientation = message.transform.translation, message.transform.rotation
    position.x, position.y, position.z = translation
    orientation.x, orientation.y, orientation.z, orientation.w = rotation
    (core.set_transform_static if is_static else core.set_transform)(message, "peer")


def lookup(target, source, time_ns):
    return as_record(core.lookup_transform_core(target, source, as_time(time_ns)))


def lookup_through(target, target_time_ns, source, source_time_ns, fixed):
    found = core.lookup_transform_full_core(
        target, as_time(target_time_ns), source, as_time(source_time_ns), fixed
    )
    return as_record(found)


def as_record(found):
    position, orientation = found.transform.translation, found.transform.rotation
    return [
        found.header.stamp.to_nsec(),
        [position.x, position.y, position.z],
        [orientation.x, orientation.y, orientation.z, orientation.w],
    ]


def chain(target, source):
    return core._chain(target, rospy.Time(), source, rospy.Time(), target)


OPERATIONS = {
    "set": set_transform,
    "lookup": lookup,
    "through": lookup_through,
    "chain": chain,
    "yaml": lambda: core.all_frames_as_yaml(),
    "string": lambda: core.all_frames_as_string(),
    "why": lambda *arguments: core.can_transform_core(*arguments[:2], as_time(arguments[2]))[1],
}

core = tf2_py.BufferCore(rospy.Duration(10))
for line in sys.stdin:
    name, *arguments = json.loads(line)
    try:
        answer = {"value": OPERATIONS[name](*arguments)}
    except tf2_py.TransformException as error:
        answer = {"error": type(error).__name__, "text": str(error)}
    print(json.dumps(answer))
