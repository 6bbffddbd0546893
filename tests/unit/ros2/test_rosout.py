"""A node's log messages on ROS 2."""

from __future__ import annotations

import pytest

from rostether.graph.log_message import LOG_TYPE
from rostether.graph.ports import Level
from rostether.msgdef.registry import Registry
from rostether.ros2.rosout import RosoutLog, logger_name
from rostether.rostime import Time
from rostether.serde.store import TypeStore


@pytest.mark.parametrize(("node", "logger"), [("/board", "board"), ("/lab/robot/board", "lab.robot.board")])
def test_a_logger_has_the_name_of_its_node(node: str, logger: str) -> None:
    assert logger_name(node) == logger


def test_messages_are_encoded() -> None:
    codec = TypeStore(Registry()).codec(LOG_TYPE.name)
    log = RosoutLog("/lab/board", lambda: Time(12, 34))
    for sequence in (1, 2):
        message = codec.decode(log.encode(Level.WARN, "too hot: 90 °C"))
        assert message.header.seq == sequence
        assert message.header.stamp == Time(12, 34)
        assert (message.level, message.name, message.msg) == (Level.WARN, "lab.board", "too hot: 90 °C")
