"""tf2_ros.BufferClient: asks the buffer of another node, and prints the answers."""

# Written as users write their nodes.
import rospy
import tf
import tf2_ros
from geometry_msgs.msg import TransformStamped

rospy.init_node("asker")
broadcaster = tf.TransformBroadcaster()
static = tf2_ros.StaticTransformBroadcaster()
dock = TransformStamped()
dock.header.frame_id, dock.child_frame_id = "odom", "dock"
dock.transform.translation.y = dock.transform.rotation.w = 1
static.sendTransform(dock)
stamp = rospy.Time.now()
client = tf2_ros.BufferClient("tf2_buffer_server")
print(client.wait_for_server(rospy.Duration(60)))
for _ in range(100):
    if client.can_transform("odom", "wheel", stamp, rospy.Duration(0.1)):
        break
    broadcaster.sendTransform((1, 0, 0.5), (0, 0, 0.6, 0.8), stamp, "wheel", "odom")
    rospy.sleep(0.1)
found = client.lookup_transform("odom", "wheel", stamp, rospy.Duration(10))
print(found.header.frame_id, found.child_frame_id, round(found.transform.translation.y, 6))
found = client.lookup_transform_full("dock", rospy.Time(0), "wheel", stamp, "odom")
print(found.header.frame_id, round(found.transform.translation.y, 6))
print(client.can_transform_full("dock", rospy.Time(0), "never", stamp, "odom"))
for frames in (("odom", "never"), ("", "dock")):
    try:
        client.lookup_transform(*frames, rospy.Time(0))
    except tf2_ros.TransformException as error:
        print(type(error).__name__, error)
try:
    client.lookup_transform("odom", "wheel", stamp - rospy.Duration(30))
except tf2_ros.ExtrapolationException:
    print("before the first transform")
try:
    tf2_ros.BufferClient("none", timeout_padding=rospy.Duration(0.2)).lookup_transform("a", "b", stamp)
except tf2_ros.TimeoutException:
    print("no server")
