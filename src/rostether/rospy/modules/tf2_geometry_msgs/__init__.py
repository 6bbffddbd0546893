"""tf2_geometry_msgs: importing it lets buffers transform stamped geometry."""

from rostether.rospy.tf.geometry import (
    do_transform_point,
    do_transform_pose,
    do_transform_vector3,
    do_transform_wrench,
    register,
)

register()
