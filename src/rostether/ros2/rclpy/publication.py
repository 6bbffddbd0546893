"""The publisher of one topic, shared by all handles of a node."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from typing import Any

from rostether.errors import SerializationError, TypeMismatchError
from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.ros2.rclpy.failures import first_lines
from rostether.ros2.rclpy.installation import load_rclpy, message_class
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.quality import name_policy, publisher_profile
from rostether.ros2.types.type_support import MessageSupport

# The time that a closing publisher waits for acknowledgements of its last messages: many round trips.
ACKNOWLEDGE_S = 0.1

# The polling interval for acknowledgements while paused: a hundredth of what users notice.
ACKNOWLEDGE_POLL_S = 0.01


class Publication:
    """One publisher of rclpy. Opened and closed in the executor's thread."""

    # The middleware does not report the losses of slow subscribers to publishers.
    dropped_count = 0

    def __init__(
        self, own: OwnNode, topic: str, message_type: MessageType, support: MessageSupport, *, latch: bool
    ) -> None:
        self.topic = topic
        self.type = message_type
        self.support = support
        self.handle_count = 0
        self._own = own
        self._latch = latch
        self._has_complained = False
        self._publisher: Any = None

    def open(self) -> None:
        """Advertise. Raises GraphError, InvalidNameError, TypeMismatchError, UnknownTypeError."""
        events = load_rclpy().events.PublisherEventCallbacks(
            incompatible_qos=self._explain_mismatch, use_default_callbacks=False
        )
        type_class = message_class(self.support.name)
        self._publisher = self._own.create_for_topic(
            f"publish {self.topic}",
            self.topic,
            self.support.name,
            lambda: self._own.node.create_publisher(
                type_class,
                self.topic,
                publisher_profile(latch=self._latch),
                callback_group=self._own.group,
                event_callbacks=events,
            ),
        )
        try:
            self._own.check_definition(self._own.node.get_publishers_info_by_topic(self.topic), self.support)
        except TypeMismatchError:
            self.close()
            raise

    @property
    def subscriber_count(self) -> int:
        """How many subscribers are connected now."""
        publisher = self._publisher
        return 0 if publisher is None else int(publisher.get_subscription_count())

    def publish(self, payloads: Sequence[bytes]) -> bool:
        """Send to every subscriber, in order; in the event loop.

        Always True: no subscriber of ROS 2 slows its publishers down.
        """
        publisher = self._publisher
        # Without subscribers, messages cost nothing.
        if publisher is None or not (self._latch or publisher.get_subscription_count()):
            return True
        try:
            converted = self.support.converter.to_cdr_all(payloads)
        except SerializationError:
            converted = self._convert_one_by_one(payloads)
        try:
            for each in converted:
                publisher.publish(each)
        except Exception as error:  # noqa: BLE001 - an error of the middleware must not end the caller
            self._complain(f"cannot publish on {self.topic}: {first_lines(str(error))}")
        return True

    async def drained(self, timeout_s: float) -> None:
        """Wait until reliable subscribers have received everything, `timeout_s` at most.

        A publisher may know a subscriber that does not know it yet. Such a subscriber drops messages, and the
        middleware sends them again.
        """
        deadline_s = time.monotonic() + timeout_s
        # The middleware does not report acknowledgements; polling is cheap.
        while not self._is_acknowledged() and time.monotonic() < deadline_s:  # noqa: ASYNC110
            await asyncio.sleep(ACKNOWLEDGE_POLL_S)

    def close(self) -> None:
        """Unadvertise."""
        publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.wait_for_all_acked(load_rclpy().duration.Duration(seconds=ACKNOWLEDGE_S))
            self._own.node.destroy_publisher(publisher)

    def _is_acknowledged(self) -> bool:
        publisher = self._publisher
        return publisher is None or bool(publisher.wait_for_all_acked(load_rclpy().duration.Duration()))

    def _convert_one_by_one(self, payloads: Sequence[bytes]) -> list[bytes]:
        converted = []
        for payload in payloads:
            try:
                converted.append(self.support.converter.to_cdr(payload))
            except SerializationError as error:
                self._complain(f"dropped a message for {self.topic}: {error}")
        return converted

    def _complain(self, text: str) -> None:
        # Reported once: the next errors are probably the same.
        if not self._has_complained:
            self._has_complained = True
            self._own.report(Level.WARN, text)

    def _explain_mismatch(self, event: Any) -> None:
        policy = name_policy(event)
        advice = (
            "it requests earlier messages, but this publisher keeps none; subscribe with durability volatile"
            if policy == "durability"
            else f"it requests another {policy} than this publisher offers; change its quality of service"
        )
        self._own.report_from_thread(
            Level.WARN,
            f"a subscriber receives nothing of {self.topic}: {advice} (ros2 topic info --verbose "
            f"{self.topic})",
        )
