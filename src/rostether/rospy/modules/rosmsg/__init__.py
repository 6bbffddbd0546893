"""rosmsg: definitions."""

# ruff: noqa: F401
from rostether.rospy.client.definition_texts import (
    ROSMsgException,
    get_msg_text,
    get_srv_text,
    list_msgs,
    list_srvs,
)
