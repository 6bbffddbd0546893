"""Uses tf and tf2_ros (rotations, lookups through time, errors, listeners, broadcasters), and prints the
results.
"""

# Written as users write their nodes.
# ruff: noqa: BLE001, F403, F405

import itertools
import math
import random
import sys

import rospy
import tf
import tf2_py
import tf2_ros
from geometry_msgs.msg import PointStamped, PoseStamped, QuaternionStamped, TransformStamped, Vector3Stamped
from tf.listener import TransformListener
from tf.transformations import *
from tf2_ros.buffer import Buffer


def show(values):
    if hasattr(values, "tolist"):
        values = values.tolist()
    if isinstance(values, (list, tuple)):
        return "[" + ", ".join(show(value) for value in values) + "]"
    return "%.9f" % (values + 0.0 if abs(values) > 1e-12 else 0.0)


def attempt(label, function):
    try:
        print(label, "->", function())
    except Exception as error:
        print(label, "raises", type(error).__name__, str(error)[:60])


def transform(parent, child, stamp, x=0.0, y=0.0, z=0.0, rotation=(0, 0, 0, 1)):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, rospy.Time(stamp)
    message.transform.translation.x, message.transform.translation.y, message.transform.translation.z = (
        x,
        y,
        z,
    )
    turn = message.transform.rotation
    turn.x, turn.y, turn.z, turn.w = rotation
    return message


random.seed(4)
AXES = [
    frame + "".join(letters)
    for frame in "sr"
    for letters in itertools.product("xyz", repeat=3)
    if letters[0] != letters[1] and letters[1] != letters[2]
]
for axes in AXES:
    for _ in range(5):
        angles = [random.uniform(-3, 3) for _ in range(3)]
        quaternion = quaternion_from_euler(*angles, axes=axes)
        print(
            axes,
            show(quaternion),
            show(euler_from_quaternion(quaternion, axes)),
            show(euler_matrix(*angles, axes)),
        )
for _ in range(20):
    one, two = (quaternion_from_euler(*[random.uniform(-3, 3) for _ in range(3)]) for _ in range(2))
    print(show(quaternion_multiply(one, two)), show(quaternion_inverse(one)), show(quaternion_conjugate(two)))
    print(show(quaternion_slerp(one, two, 0.3)), show(quaternion_from_matrix(quaternion_matrix(one))))
    matrix = concatenate_matrices(translation_matrix((1, 2, 3)), quaternion_matrix(two))
    print(show(inverse_matrix(matrix)), show(translation_from_matrix(matrix)), show(vector_norm(one)))
print(show(quaternion_about_axis(1.0, (1, 2, 3))), show(rotation_matrix(0.5, (0, 1, 1), (1, 2, 3))))
print(
    show(unit_vector([3, 4])),
    show(identity_matrix()),
    show(euler_from_quaternion((0, math.sqrt(0.5), 0, math.sqrt(0.5)))),
)

without_node = tf2_py.BufferCore(rospy.Duration(10))
without_node.set_transform(transform("world", "cart", 5, 1), "recording")
without_node.set_transform_static(transform("cart", "lamp", 0, 0, 2), "recording")
found = without_node.lookup_transform_core("world", "lamp", rospy.Time(5)).transform.translation
print(show([found.x, found.y, found.z]), tf2_ros.BufferCore is tf2_py.BufferCore)
attempt("no node", lambda: without_node.lookup_transform_core("world", "moon", rospy.Time(5)))

registration = tf2_ros.ConvertRegistration()
registration.add_to_msg(float, str)
registration.add_from_msg(int, lambda text: int(float(text)))
registration.add_convert((str, int), len)
print(tf2_ros.convert(2.6, int), tf2_ros.convert(3, int), tf2_ros.convert("four", int))
attempt("convert", lambda: tf2_ros.convert([], int))
stamped = tf2_ros.Stamped(PointStamped(), rospy.Time(3), "map")
print(stamped.header.frame_id, stamped.header.stamp)

rospy.init_node("frames")
buffer = tf2_ros.Buffer(rospy.Duration(100), debug=False)
turn = quaternion_from_euler(0.1, 0.2, 0.3)
buffer.set_transform(transform("world", "base", 10, 1, 2, 3, turn), "me")
buffer.set_transform(transform("world", "base", 12, 2, 2, 3, quaternion_from_euler(0.5, 0.2, 0.3)), "me")
buffer.set_transform_static(transform("base", "arm", 0, 0.5, 0, 0, quaternion_from_euler(0, 0, 1)), "me")
buffer.set_transform(transform("/other", "island", 11), "me")
for stamp in (0, 10, 10.5, 12):
    found = buffer.lookup_transform("world", "arm", rospy.Time(stamp))
    place, rotation = found.transform.translation, found.transform.rotation
    print(found.header.stamp, found.header.frame_id, found.child_frame_id)
    print(show([place.x, place.y, place.z, rotation.x, rotation.y, rotation.z, rotation.w]))
attempt("unknown", lambda: buffer.lookup_transform("world", "nowhere", rospy.Time(0)))
attempt("future", lambda: buffer.lookup_transform("world", "arm", rospy.Time(13)))
attempt("past", lambda: buffer.lookup_transform("world", "arm", rospy.Time(9)))
attempt("apart", lambda: buffer.lookup_transform("world", "island", rospy.Time(0)))
attempt("slash", lambda: buffer.lookup_transform("/world", "arm", rospy.Time(0)))
attempt("empty", lambda: buffer.lookup_transform("", "arm", rospy.Time(0)))
attempt("timeout", lambda: buffer.lookup_transform("world", "soon", rospy.Time(0), rospy.Duration(0.2)))
for moment in (11, 20):
    print(bool(buffer.can_transform("world", "arm", rospy.Time(moment))))
print(len(buffer.can_transform("world", "arm", rospy.Time(20), return_debug_tuple=True)[1]) > 20)
print(
    show(
        buffer.lookup_transform_full(
            "arm", rospy.Time(10), "arm", rospy.Time(12), "world"
        ).transform.translation.x
    )
)
print(
    issubclass(tf2_ros.LookupException, tf2_ros.TransformException),
    tf.Exception is tf2_ros.TransformException,
)

driven = tf.Transformer()
driven.setTransform(transform("odom", "base", 20, 1, 2, 0, turn))
driven.setTransform(transform("odom", "base", 21, 1.5, 2.5, 0.1, quaternion_from_euler(0.4, -0.2, 1)))
driven.setTransform(transform("map", "odom", 20, 3, 0, 1, quaternion_from_euler(0.1, 0.2, 0.3)))
driven.setTransform(transform("map", "odom", 21, 3, 0, 1, quaternion_from_euler(0.1, 0.2, 0.3)))
second = rospy.Duration(1)
print("twist", show(driven.lookupTwist("/base", "/odom", rospy.Time(0), second)))
print(show(driven.lookupTwist("odom", "base", rospy.Time(20.5), rospy.Duration(0.5))))
print(show(driven.lookupTwistFull("base", "odom", "map", (0, 0, 0), "odom", rospy.Time(20.75), second)))
print(
    tf.broadcaster.TransformBroadcaster is tf.TransformBroadcaster,
    TransformListener is tf.listener.TransformListener is tf.TransformListener,
    tf2_ros.buffer.Buffer is tf2_ros.Buffer is Buffer,
    tf2_ros.transform_listener.TransformListener is tf2_ros.TransformListener,
)

listener = tf.TransformListener()
broadcaster = tf.TransformBroadcaster()
static = tf2_ros.StaticTransformBroadcaster()
static.sendTransform([transform("map", "odom", 1, 5, 0, 0, turn), transform("map", "dock", 1, 0, 1, 0)])
stamp = rospy.Time.now()
for _ in range(3000):
    broadcaster.sendTransform((1, 0, 0.5), quaternion_from_euler(0, 0, 0.7), stamp, "wheel", "odom")
    rospy.sleep(0.02)
    if listener.canTransform("map", "wheel", stamp):
        break
listener.waitForTransform("/map", "/wheel", stamp, rospy.Duration(60))
print(show(listener.lookupTransform("/map", "/wheel", rospy.Time(0))))
print(sorted(listener.getFrameStrings()), listener.frameExists("wheel"))
attempt("listener", lambda: listener.lookupTransform("map", "nothing", rospy.Time(0)))
attempt("wait", lambda: listener.waitForTransform("map", "nothing", rospy.Time(0), rospy.Duration(0.1)))
point, pose, vector, quaternion = PointStamped(), PoseStamped(), Vector3Stamped(), QuaternionStamped()
for message in (point, pose, vector, quaternion):
    message.header.frame_id, message.header.stamp = "wheel", stamp
point.point.x, pose.pose.position.y, pose.pose.orientation.w = 1, 2, 1
vector.vector.z, quaternion.quaternion.w = 3, 1
moved = listener.transformPoint("map", point)
print(moved.header.frame_id, show([moved.point.x, moved.point.y, moved.point.z]))
moved = listener.transformPose("map", pose).pose
print(show([moved.position.x, moved.position.y, moved.position.z, moved.orientation.x, moved.orientation.w]))
moved = listener.transformVector3("map", vector).vector
print(show([moved.x, moved.y, moved.z]))
moved = listener.transformQuaternion("map", quaternion).quaternion
print(show([moved.x, moved.y, moved.z, moved.w]), show(listener.asMatrix("map", point.header)))
sys.stdout.flush()
