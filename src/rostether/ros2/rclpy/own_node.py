"""One rclpy node: the common part of its publishers, subscribers and services."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from rostether.errors import TypeMismatchError
from rostether.graph.log_message import MAX_LOG_TEXT_BYTES, ROSOUT
from rostether.graph.ports import Level
from rostether.ros2.naming import logger_name
from rostether.ros2.rclpy.executor_thread import ExecutorThread
from rostether.ros2.rclpy.failures import attempt, first_lines
from rostether.ros2.rclpy.installation import interface_class, load_rclpy
from rostether.ros2.rclpy.quality import rosout_profile
from rostether.ros2.rclpy.view import node_name_of, offered_types
from rostether.ros2.types.type_support import MessageSupport, Ros2Types

_HASH_PREFIX = "RIHS01_"
# Eight digits of a hash are enough to distinguish two definitions.
_SHOWN_HASH = len(_HASH_PREFIX) + 8

_Result = TypeVar("_Result")
_log = logging.getLogger("rostether.ros2")


class OwnNode:
    """A node of rclpy, `node`, with the callback group of its endpoints, `group`.

    Create and destroy it in the executor's thread. Raises GraphError, InvalidNameError.
    """

    def __init__(
        self,
        full_name: str,
        *,
        context: Any,
        thread: ExecutorThread,
        types: Ros2Types,
        arguments: Sequence[str],
    ) -> None:
        rclpy = load_rclpy()
        namespace, _, name = full_name.rpartition("/")
        self.name = full_name
        self.thread = thread
        self.types = types
        self.node = attempt(
            f"join as {full_name}",
            lambda: rclpy.node.Node(
                name,
                namespace=namespace or "/",
                context=context,
                cli_args=list(arguments),
                use_global_arguments=False,
                # rcl's logging would also print every line to the console.
                enable_rosout=False,
                allow_undeclared_parameters=True,
                automatically_declare_parameters_from_overrides=True,
            ),
        )
        # A handler that waits must not delay other handlers.
        self.group = rclpy.callback_groups.ReentrantCallbackGroup()
        self._rosout = self.node.create_publisher(
            interface_class("rcl_interfaces/msg/Log"),
            ROSOUT,
            rosout_profile(),
            callback_group=self.group,
            event_callbacks=rclpy.events.PublisherEventCallbacks(use_default_callbacks=False),
        )
        self._logger_name = logger_name(full_name)
        thread.executor.add_node(self.node)

    def log(self, level: Level, text: str) -> None:
        """Publish a log message on /rosout, like rcl."""
        log = interface_class("rcl_interfaces/msg/Log")
        try:
            self._rosout.publish(
                log(
                    stamp=self.node.get_clock().now().to_msg(),
                    level=level.number_in_tens,
                    name=self._logger_name,
                    msg=text.encode("utf-8", "replace")[:MAX_LOG_TEXT_BYTES].decode("utf-8", "ignore"),
                )
            )
        except Exception as error:  # noqa: BLE001 - a failing log line must not end the caller
            _log.debug("cannot log on %s: %s", ROSOUT, first_lines(str(error)))

    def now_ns(self) -> int:
        """Return ROS time in nanoseconds."""
        return int(self.node.get_clock().now().nanoseconds)

    def report(self, level: Level, text: str) -> None:
        """Log a line about this node, and publish it on /rosout. Call it in the event loop."""
        _log.log(level.number_in_tens, "%s: %s", self.name, text)
        self.log(level, text)

    def report_from_thread(self, level: Level, text: str) -> None:
        """Log a line about this node from the executor's thread."""
        self.thread.call_in_loop(self.report, level, text)

    def create(
        self,
        what: str,
        type_name: str,
        function: Callable[[], _Result],
        types_in_use: Callable[[], list[str]],
    ) -> _Result:
        """Create an endpoint in the executor's thread.

        `types_in_use` returns the types of its topic or service, for the error if another type is in use.
        Raises GraphError and its subclasses, InvalidNameError.
        """
        try:
            return attempt(what, function)
        except TypeMismatchError as error:
            others = " and ".join(sorted(set(types_in_use()) - {type_name})) or "another type"
            raise TypeMismatchError(
                f"cannot {what} as {type_name}: this process already uses it as {others}"
                ", and this middleware allows only one type per name; choose another name, or use zenoh"
            ) from error

    def topic_types(self, topic: str) -> list[str]:
        """Return the types of a topic; call it in the executor's thread."""
        return list(dict(self.node.get_topic_names_and_types()).get(topic, ()))

    def service_types(self, service: str) -> list[str]:
        """Return the types of a service's servers; call it in the executor's thread."""
        return offered_types(self.node, service)

    def destroy(self) -> None:
        """Leave the graph; call it in the executor's thread."""
        self.thread.executor.remove_node(self.node)
        self.node.destroy_node()

    def check_definition(self, endpoints: Sequence[Any], support: MessageSupport) -> None:
        """Compare the hash of an installed type with the known one.

        `endpoints` are rclpy's descriptions of a topic's endpoints; that of this node has the installed hash.
        Raises TypeMismatchError if the hashes differ, because the serialized bytes would also differ. Humble
        has no hashes.
        """
        for endpoint in endpoints:
            installed = str(getattr(endpoint, "topic_type_hash", ""))
            if (
                node_name_of(endpoint) == self.name
                and endpoint.topic_type == support.name
                and installed.startswith(_HASH_PREFIX)
                and support.type_hash.startswith(_HASH_PREFIX)
                and installed != support.type_hash
            ):
                raise TypeMismatchError(
                    f"the definition of {support.name} that is installed for rclpy differs from the known "
                    f"one ({installed[:_SHOWN_HASH]}..., not {support.type_hash[:_SHOWN_HASH]}...); give its "
                    "folder with --msg-path, or set ROS_DISTRO to the distribution that is installed"
                )
