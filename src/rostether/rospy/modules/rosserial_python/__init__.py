"""rosserial_python: a board served by the program's own node."""

# ruff: noqa: F401
from rostether.rospy.client.serial_client import RosSerialServer, SerialClient
