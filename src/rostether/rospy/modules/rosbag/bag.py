"""rosbag.bag, as programs import it."""

# ruff: noqa: F401
from rostether.rospy.bag.bag import Bag
from rostether.rospy.bag.facts import (
    BagMessage,
    BagMessageWithConnectionHeader,
    Compression,
    CompressionTuple,
    TopicTuple,
    TypesAndTopicsTuple,
)
from rostether.rospy.bag.types import (
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
)
