"""Looks frames up with Debian's tf2. Reads JSON from standard input, writes JSON.

Input: transforms as [parent, child, time, x, y, z, qx, qy, qz, qw, is_static],
lookups as [target, source, time].
Output: for each lookup seven numbers.
"""

import json
import sys

import rospy
from geometry_msgs.msg import TransformStamped
from tf2_py import BufferCore

script = json.load(sys.stdin)
buffer = BufferCore(rospy.Duration(30))
for parent, child, time_s, x, y, z, qx, qy, qz, qw, is_static in script["transforms"]:
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = parent, child
    message.header.stamp = rospy.Time.from_sec(time_s)
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = x, y, z
    rotation.x, rotation.y, rotation.z, rotation.w = qx, qy, qz, qw
    (buffer.set_transform_static if is_static else buffer.set_transform)(message, "test")
found = []
for target, source, time_s in script["lookups"]:
    pose = buffer.lookup_transform_core(target, source, rospy.Time.from_sec(time_s)).transform
    translation, rotation = pose.translation, pose.rotation
    found.append(
        [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z, rotation.w]
    )
print(json.dumps(found))
