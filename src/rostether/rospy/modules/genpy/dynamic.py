"""genpy.dynamic."""

# ruff: noqa: F401
from rostether.rospy.client.dynamic_messages import generate_dynamic
