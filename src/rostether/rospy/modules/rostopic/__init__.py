"""rostopic: topics, their types and figures."""

# ruff: noqa: F401
from rostether.rospy.tools.topic_figures import ROSTopicBandwidth, ROSTopicDelay, ROSTopicHz
from rostether.rospy.tools.topic_lookup import (
    ROSTopicException,
    ROSTopicIOException,
    create_publisher,
    find_by_type,
    get_topic_class,
    get_topic_list,
    get_topic_type,
    msgevalgen,
    publish_message,
)
