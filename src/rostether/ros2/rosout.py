"""A node's log messages on /rosout, with the names and levels of rcl.

They are created as rosgraph_msgs/Log, the graph port's log type; on ROS 2 they are sent as
rcl_interfaces/msg/Log with its levels. The topic's quality of service is `qos.ROSOUT_QOS`.
"""

from __future__ import annotations

from collections.abc import Callable

from rostether.graph.log_message import encode_log
from rostether.graph.ports import Level
from rostether.rostime import Time


class RosoutLog:
    """Encodes the log messages of one node."""

    def __init__(self, node_name: str, now: Callable[[], Time]) -> None:
        self._logger = logger_name(node_name)
        self._now = now
        self._sequence = 0

    def encode(self, level: Level, text: str) -> bytes:
        """Return one serialized message, stamped now."""
        self._sequence += 1
        return encode_log(
            sequence=self._sequence, stamp=self._now(), level=level, node_name=self._logger, text=text
        )


def logger_name(node_name: str) -> str:
    """Return the name of a node's logger: `/lab/board` logs as `lab.board`."""
    return node_name.strip("/").replace("/", ".")
