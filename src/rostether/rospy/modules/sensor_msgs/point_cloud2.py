"""sensor_msgs.point_cloud2: reads and creates point clouds."""

from rostether.rospy.client.message_types import all_types as _all_types
from rostether.rospy.tf.point_cloud import DATATYPES as _DATATYPES
from rostether.rospy.tf.point_cloud import create_cloud, create_cloud_xyz32, read_points, read_points_list
from rostether.rospy.tf.point_cloud import struct_format as _get_struct_fmt

PointCloud2 = _all_types().message_class("sensor_msgs/PointCloud2")
PointField = _all_types().message_class("sensor_msgs/PointField")
