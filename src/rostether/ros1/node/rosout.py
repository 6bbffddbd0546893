"""The node's own log messages on /rosout."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rostether.graph.log_message import LOG_TYPE, ROSOUT, encode_log
from rostether.graph.ports import Level
from rostether.ros1.node.publication import Publication
from rostether.rostime import Time


class RosoutLog:
    """Publishes logs; latched as roscpp's and rospy's, so that who comes later sees the last one."""

    def __init__(
        self, node_name: str, *, now: Callable[[], Time], published_topics: Callable[[], Iterable[str]]
    ) -> None:
        # Its own troubles cannot be reported through itself.
        self.publication = Publication(
            ROSOUT, LOG_TYPE, node_name=node_name, report=lambda _level, _text: None, latch=True
        )
        self._node_name = node_name
        self._now = now
        self._published_topics = published_topics
        self._sequence = 0

    def log(self, level: Level, text: str) -> None:
        """Publish one message."""
        self._sequence += 1
        message = encode_log(
            sequence=self._sequence,
            stamp=self._now(),
            level=level,
            node_name=self._node_name,
            text=text,
            topics=self._published_topics(),
        )
        self.publication.publish([message])
