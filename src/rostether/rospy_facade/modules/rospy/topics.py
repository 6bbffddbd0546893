"""rospy.topics."""

# ruff: noqa: F401
from rostether.rospy_facade.message import Message
from rostether.rospy_facade.publisher import Publisher, SubscribeListener
from rostether.rospy_facade.subscriber import Subscriber
