"""init_node, spin, and the other functions with which a rospy program starts."""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
import warnings
from typing import Any

from rostether.graph.log_message import ROSOUT
from rostether.graph.ports import Level
from rostether.rospy.client import logs
from rostether.rospy.client.exceptions import ROSException, ROSInitException, ROSInterruptException
from rostether.rospy.client.message import Message
from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.names import is_remap_argument, names
from rostether.rospy.client.node import node
from rostether.rospy.client.parameters import set_param
from rostether.rospy.client.publisher import Publisher
from rostether.rospy.client.ros_time import Time
from rostether.rospy.client.services import Service
from rostether.rospy.client.shutdown import is_shutdown, shutdown
from rostether.rospy.client.stamps import in_seconds
from rostether.rospy.client.subscriber import Subscriber
from rostether.rospy.client.topic import topics

_init_arguments: tuple[Any, ...] | None = None


def init_node(  # noqa: PLR0913 - as rospy.init_node
    name: str,
    argv: list[str] | None = None,
    anonymous: bool = False,
    log_level: int | None = None,
    disable_rostime: bool = False,
    disable_rosout: bool = False,
    disable_signals: bool = False,
    xmlrpc_port: int = 0,
    tcpros_port: int = 0,
) -> None:
    """Wait for the master and join the graph as a node; `xmlrpc_port` and `tcpros_port` have no effect.

    Raises ValueError for a name that is empty or has a namespace, ROSException for other arguments than in
    the first call, and ROSInitException if the node cannot join.
    """
    global _init_arguments
    if argv is None:
        argv = sys.argv
    else:
        names.load(argv)
    if not name:
        raise ValueError("name must not be empty")
    if "/" in name:
        raise ValueError("namespaces are not allowed in node names")
    arguments = (name, argv, anonymous, log_level, disable_rostime, disable_signals)
    if _init_arguments is not None:
        if _init_arguments != arguments:
            raise ROSException(
                f"rospy.init_node() has already been called with different arguments: {_init_arguments}"
            )
        return
    _init_arguments = arguments
    if not (disable_signals or hasattr(sys, "ps1")):
        shutdown.register_signals()
    if "__name" in names.mappings:
        name, anonymous = names.mappings["__name"], False
    if anonymous:
        name = f"{name}_{os.getpid()}_{int(time.time() * 1000)}"
    full_name = names.set_node_name(name)
    logs.configure(log_level)
    try:
        node.join(full_name)
    except ROSInterruptException:
        raise ROSInitException("init_node interrupted before it could complete") from None
    for param_name, value in names.private_params.items():
        set_param(f"~{param_name}", value)
    node.is_initialized = True
    if not disable_rosout:
        _publish_logs()
    Service("~get_loggers", all_types().service_class("roscpp/GetLoggers"), _get_loggers)
    Service("~set_logger_level", all_types().service_class("roscpp/SetLoggerLevel"), _set_logger_level)


def spin() -> None:
    """Wait until the node is shut down. Raises ROSInitException before init_node."""
    if not node.is_initialized:
        raise ROSInitException("client code must call rospy.init_node() first")
    try:
        while not shutdown.event.wait(0.5):
            pass
    except KeyboardInterrupt:
        shutdown.signal("keyboard interrupt")


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return a command line (default: this program's) without the arguments of ROS."""
    return [argument for argument in (sys.argv if argv is None else argv) if not is_remap_argument(argument)]


def wait_for_message(topic: str, topic_type: type[Message], timeout: Any = None) -> Any:
    """Return the next message of a topic.

    Raises ROSException after `timeout` seconds (or a Duration), ROSInterruptException at a shutdown.
    """
    timeout_s = in_seconds(timeout)
    deadline_s = None if timeout_s is None else time.monotonic() + timeout_s
    found: list[Message] = []
    arrived = threading.Event()

    def on_message(message: Message) -> None:
        found.append(message)
        arrived.set()

    subscriber = Subscriber(topic, topic_type, on_message)
    try:
        while not is_shutdown() and not arrived.wait(0.1):
            if deadline_s is not None and time.monotonic() >= deadline_s:
                raise ROSException(f"timeout exceeded while waiting for message on topic {topic}")
    finally:
        subscriber.unregister()
    if not found:
        raise ROSInterruptException("rospy shutdown")
    return found[0]


def _publish_logs() -> None:
    log_class: Any = all_types().message_class("rosgraph_msgs/Log")
    publisher = Publisher(ROSOUT, log_class, latch=True, queue_size=100)

    def publish(record: logging.LogRecord) -> None:
        # Lines of forked workers are only printed: a fork has no node.
        if node.loop.is_lost:
            return
        message = log_class(**logs.log_fields(record, topics.names()))
        message.header.stamp = Time.now()
        publisher.publish(message)

    logs.publish_logs(publish)


def _get_loggers(request: Message) -> Any:
    types = all_types()
    logger_class: Any = types.message_class("roscpp/Logger")
    response: Any = types.service_class("roscpp/GetLoggers")._response_class()
    for name in list(logging.Logger.manager.loggerDict):
        level = logging.getLogger(name).getEffectiveLevel()
        response.loggers.append(logger_class(name, logs.LEVELS.get(level, Level.INFO).name))
    return response


def _set_logger_level(request: Any) -> Any:
    try:
        level = Level[request.level.upper()]
    except KeyError:
        warnings.warn(f"Bad logging level: {request.level}", stacklevel=2)
    else:
        logging.getLogger(request.logger).setLevel(level.number_in_tens)
    return all_types().service_class("roscpp/SetLoggerLevel")._response_class()
