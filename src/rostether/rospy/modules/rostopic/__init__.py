"""rostopic: topics, their types and statistics."""

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
from rostether.rospy.tools.topic_statistics import ROSTopicBandwidth, ROSTopicDelay, ROSTopicHz
