"""rospy.service."""

# ruff: noqa: F401
from rostether.rospy.client.exceptions import ServiceException
