"""rosbag.bag."""

# ruff: noqa: F401
from rostether.rospy.bag.bag import Bag
from rostether.rospy.bag.exceptions import (
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
)
from rostether.rospy.bag.facts import (
    BagMessage,
    BagMessageWithConnectionHeader,
    Compression,
    CompressionTuple,
    TopicTuple,
    TypesAndTopicsTuple,
)
