"""sensor_msgs.point_cloud2: reads and creates point clouds."""

# ruff: noqa: F401
from rostether.rospy.tf.point_cloud import DATATYPES as _DATATYPES
from rostether.rospy.tf.point_cloud import create_cloud, create_cloud_xyz32, read_points, read_points_list
from rostether.rospy.tf.point_cloud import struct_format as _get_struct_fmt
