"""rosbag: reads and writes bags."""

from rostether.rospy.bag.bag import Bag
from rostether.rospy.bag.facts import Compression
from rostether.rospy.bag.types import ROSBagException, ROSBagFormatException, ROSBagUnindexedException
