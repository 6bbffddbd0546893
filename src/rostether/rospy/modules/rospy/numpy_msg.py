"""rospy.numpy_msg: messages whose arrays of numbers are numpy arrays."""

# ruff: noqa: F401
from rostether.rospy.client.numpy_messages import numpy_msg
