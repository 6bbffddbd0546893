"""message_filters: messages of several topics together."""

# ruff: noqa: F401
from rostether.rospy.client.message_filters import (
    ApproximateTimeSynchronizer,
    Cache,
    SimpleFilter,
    Subscriber,
    TimeSynchronizer,
)
