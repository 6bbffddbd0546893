"""A board with MicroPython or CircuitPython as a node of a ROS graph: a client of the rosserial protocol.

The names are those of the C++ library.
"""

from ros.node_handle import SPIN_ERR, SPIN_OK, SPIN_TIMEOUT, NodeHandle
from ros.publisher import Publisher
from ros.service_client import ServiceClient
from ros.service_server import ServiceServer
from ros.subscriber import Subscriber
from ros.times import Duration, Time

__all__ = (
    "SPIN_ERR",
    "SPIN_OK",
    "SPIN_TIMEOUT",
    "Duration",
    "NodeHandle",
    "Publisher",
    "ServiceClient",
    "ServiceServer",
    "Subscriber",
    "Time",
)
