"""rosbag: bags read and written by scripts."""

# ruff: noqa: F401
from rostether.rospy_facade.bag import Bag
from rostether.rospy_facade.bag_exceptions import (
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
)
from rostether.rospy_facade.bag_facts import Compression
