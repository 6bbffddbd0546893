"""rospy.topics, as programs import it."""

# ruff: noqa: F401
from rostether.rospy.client.message import Message
from rostether.rospy.client.publisher import Publisher, SubscribeListener
from rostether.rospy.client.subscriber import Subscriber
