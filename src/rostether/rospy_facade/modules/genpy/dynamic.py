"""genpy.dynamic."""

# ruff: noqa: F401
from rostether.rospy_facade.dynamic_messages import generate_dynamic
