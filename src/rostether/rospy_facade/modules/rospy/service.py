"""rospy.service."""

# ruff: noqa: F401
from rostether.rospy_facade.exceptions import ServiceException
