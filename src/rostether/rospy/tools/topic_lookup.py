"""The Python API of rostopic: topics, their types and their fields."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from rostether.errors import ConfigError
from rostether.rospy.client.message import MessageException
from rostether.rospy.client.message_arguments import fill_message_args, get_printable_message_args
from rostether.rospy.client.message_types import all_types, get_message_class
from rostether.rospy.client.ros_time import Rate, get_rostime
from rostether.rospy.client.shutdown import is_shutdown
from rostether.rospy.tools.graph_names import ANYTYPE, script_resolve_name
from rostether.rospy.tools.master_tools import Master, master_required
from rostether.serde.field_path import read_index

# As in rostopic.
_POLL_S = 0.1

ReadField = Callable[[Any], Any]


class ROSTopicException(Exception):
    """The base of rostopic's errors."""


class ROSTopicIOException(ROSTopicException):
    """The master does not answer."""


def get_topic_type(topic: str, blocking: bool = False) -> tuple[str | None, str | None, ReadField | None]:
    """Return a topic's type, its full name, and a function that reads the field in the name, if there is one.

    All are None if the topic is unknown. With `blocking`, waits until it is known. Raises
    ROSTopicIOException.
    """
    is_reported = False
    while True:
        found = _topic_type(topic)
        if found[0] is not None or not blocking or is_shutdown():
            return found
        if not is_reported:
            is_reported = True
            sys.stderr.write(f"WARNING: topic [{topic}] does not appear to be published yet\n")
        time.sleep(_POLL_S)


def get_topic_class(topic: str, blocking: bool = False) -> tuple[Any, str | None, ReadField | None]:
    """Return a topic's message class, full name and field reader, like `get_topic_type`.

    Raises ROSTopicException if the type is unknown.
    """
    kind, name, evaluate = get_topic_type(topic, blocking)
    if kind is None:
        return None, None, None
    message_class = get_message_class(kind)
    if message_class is None:
        raise ROSTopicException(f"Cannot load message class for [{kind}]. Are your messages built?")
    return message_class, name, evaluate


def get_topic_list(master: Master | None = None) -> tuple[list[Any], list[Any]]:
    """Return published and subscribed topics, each as (name, type, nodes). Raises ROSTopicIOException."""
    master = master or Master("/rostopic")
    with master_required(ROSTopicIOException):
        publishers, subscribers, _ = master.getSystemState()
        types = dict(master.getTopicTypes())
    published, subscribed = (
        [(name, types.get(name, "unknown type"), nodes) for name, nodes in table]
        for table in (publishers, subscribers)
    )
    return published, subscribed


def find_by_type(topic_type: str) -> list[str]:
    """Return the topics of a type. Raises ROSTopicIOException."""
    return [name for name, kind in _types() if kind == topic_type]


def msgevalgen(pattern: str) -> ReadField | None:
    """Return a function that reads a field such as `/pose/position/x` or `/ranges[1:3]`.

    Returns None if the pattern names no field or is invalid.
    """
    steps: list[tuple[str, int | slice | None]] = []
    for part in filter(None, pattern.split("/")):
        name, bracket, rest = part.partition("[")
        index: int | slice | None = None
        if bracket:
            try:
                index = read_index(part, rest)
            except ConfigError:
                sys.stderr.write(f"field '{name}' has invalid slice argument '{rest.removesuffix(']')}'\n")
                return None
        steps.append((name, index))

    def read(value: Any, begin: int = 0) -> Any:
        for number, (name, index) in enumerate(steps[begin:], begin):
            try:
                value = getattr(value, name)
                if index is not None:
                    value = value[index]
            except (AttributeError, IndexError) as error:
                sys.stderr.write(f"{error}: {pattern}\n")
                return None
            if isinstance(index, slice) and number + 1 < len(steps):
                return [read(each, number + 1) for each in value]
        return value

    return read if steps else None


def create_publisher(
    topic_name: str, topic_type: str, latch: bool, disable_rostime: bool = True
) -> tuple[Any, Any]:
    """Start a node, and return a publisher and the message class of a type. Raises ROSTopicException."""
    from rostether.rospy.client.client import init_node
    from rostether.rospy.client.publisher import Publisher

    message_class = get_message_class(topic_type)
    if message_class is None:
        raise ROSTopicException(f"invalid message type: {topic_type}")
    init_node("rostopic", anonymous=True, disable_rosout=True, disable_rostime=disable_rostime)
    name = script_resolve_name("rostopic", topic_name)
    return Publisher(name, message_class, latch=latch, queue_size=100), message_class


def publish_message(
    pub: Any,
    msg_class: Any,
    pub_args: list[Any],
    rate: float | None = None,
    once: bool = False,
    verbose: bool = False,
) -> None:
    """Publish a message with these fields: once, or repeatedly at `rate` in Hz. Raises ROSTopicException.

    Without `once`, returns when the node shuts down, so that latched messages stay available.
    """
    from rostether.rospy.client.client import spin

    message = msg_class()
    now = get_rostime()
    header: Any = all_types().message_class("std_msgs/Header")
    try:
        fill_message_args(message, pub_args, keys={"now": now, "auto": header(stamp=now)})
    except MessageException as error:
        raise ROSTopicException(f"{error}\n\nArgs are: [{get_printable_message_args(message)}]") from None
    pub.publish(message)
    if rate is not None:
        pace = Rate(float(rate))
        while not is_shutdown():
            pace.sleep()
            pub.publish(message)
    elif not once:
        spin()


def _topic_type(topic: str) -> tuple[str | None, str | None, ReadField | None]:
    types = _types()
    names = [(name, kind) for name, kind in types if name == topic]
    if not names:
        longest_first = sorted((each for each in types if topic.startswith(f"{each[0]}/")), reverse=True)
        names = [each for each in longest_first if _has_field(each[1], topic[len(each[0]) + 1 :])]
    if not names or names[0][1] == ANYTYPE:
        return None, None, None
    name, kind = names[0]
    return kind, name, msgevalgen(topic[len(name) :])


def _has_field(kind: str, path: str) -> bool:
    message_class = get_message_class(kind)
    if message_class is None:
        return True
    value: Any = message_class()
    for name in path.partition("[")[0].strip("/").split("/"):
        if not hasattr(value, name):
            return False
        value = getattr(value, name)
    return True


def _types() -> list[tuple[str, str]]:
    with master_required(ROSTopicIOException):
        return [(name, kind) for name, kind in Master("/rostopic").getTopicTypes()]
