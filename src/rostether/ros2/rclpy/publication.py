"""The publisher of one topic over rclpy, shared by all handles of a node."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Sequence
from typing import Any

from rostether.errors import SerializationError, TypeMismatchError
from rostether.graph.ports import Level
from rostether.msgdef.interface import MessageType
from rostether.ros2.rclpy.failures import first_lines
from rostether.ros2.rclpy.installation import interface_class, load_rclpy
from rostether.ros2.rclpy.own_node import OwnNode
from rostether.ros2.rclpy.quality import LATCHED_DEPTH, PUBLISHER_DEPTH, name_policy, profile
from rostether.ros2.types.type_support import MessageSupport

# The time that a closing publisher waits for acknowledgements of its last messages: many round trips.
ACKNOWLEDGE_S = 0.1

# The polling interval for acknowledgements: local subscribers acknowledge within 5 ms.
ACKNOWLEDGE_POLL_S = 0.002

# The limit of latched messages that wait for acknowledgements; beyond it, the oldest is sent immediately. A
# subscriber that was killed delays each message by `ACKNOWLEDGE_S` until its lease ends, 20 s later.
MAX_BACKLOG = 1000


class RclpyPublication:
    """One publisher of rclpy. Opened and closed in the executor's thread.

    A latched publisher keeps only one message. Therefore the next one waits until all connected subscribers
    have acknowledged it, so that a burst arrives whole.
    """

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
        self._is_reported = False
        self._publisher: Any = None
        self._backlog: deque[bytes] = deque()
        self._sending: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Advertise. Raises GraphError, InvalidNameError, TypeMismatchError, UnknownTypeError."""
        events = load_rclpy().events.PublisherEventCallbacks(
            incompatible_qos=self._explain_mismatch, use_default_callbacks=False
        )
        type_class = interface_class(self.support.name)
        self._publisher = self._own.create(
            f"publish {self.topic}",
            self.support.name,
            lambda: self._own.node.create_publisher(
                type_class,
                self.topic,
                profile(LATCHED_DEPTH if self._latch else PUBLISHER_DEPTH, is_latched=self._latch),
                callback_group=self._own.group,
                event_callbacks=events,
            ),
            lambda: self._own.topic_types(self.topic),
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
        """Send messages to every subscriber, in order; call it in the event loop.

        Returns False if latched messages wait for acknowledgements; other messages never wait.
        """
        publisher = self._publisher
        # Without subscribers, messages cost nothing.
        if publisher is None or not (self._latch or publisher.get_subscription_count()):
            return True
        try:
            converted = self.support.converter.to_cdr_all(payloads)
        except SerializationError:
            converted = self._convert_one_by_one(payloads)
        if self._latch and (self._backlog or len(converted) > 1 or not self._is_acknowledged()):
            while len(self._backlog) + len(converted) > MAX_BACKLOG:
                self._send(self._backlog.popleft() if self._backlog else converted.pop(0))
            self._backlog += converted
            if self._sending is None:
                self._sending = asyncio.get_running_loop().create_task(self._send_backlog())
            return False
        for each in converted:
            self._send(each)
        return True

    async def drained(self, timeout_s: float) -> None:
        """Wait until reliable subscribers have received everything, at most `timeout_s`.

        A publisher may have discovered a subscriber before the subscriber discovers the publisher. Until then
        the subscriber drops messages, and the middleware sends them again.
        """
        deadline_s = time.monotonic() + timeout_s
        # The middleware does not report acknowledgements; polling is cheap.
        while (self._backlog or not self._is_acknowledged()) and time.monotonic() < deadline_s:  # noqa: ASYNC110
            await asyncio.sleep(ACKNOWLEDGE_POLL_S)

    def send_rest(self) -> None:
        """Send the waiting messages immediately, before the publisher closes; call it in the event loop."""
        while self._backlog:
            self._send(self._backlog.popleft())

    def close(self) -> None:
        """Unadvertise, after waiting at most `ACKNOWLEDGE_S` for acknowledgements."""
        publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.wait_for_all_acked(load_rclpy().duration.Duration(seconds=ACKNOWLEDGE_S))
            self._own.node.destroy_publisher(publisher)

    def _send(self, message: bytes) -> None:
        if self._publisher is None:
            return
        try:
            self._publisher.publish(message)
        except Exception as error:  # noqa: BLE001 - an error of the middleware must not end the caller
            self._report_once(f"cannot publish on {self.topic}: {first_lines(str(error))}")

    async def _send_backlog(self) -> None:
        while self._backlog:
            deadline_s = time.monotonic() + ACKNOWLEDGE_S
            while not self._is_acknowledged() and time.monotonic() < deadline_s:  # noqa: ASYNC110
                await asyncio.sleep(ACKNOWLEDGE_POLL_S)
            if self._backlog:
                self._send(self._backlog.popleft())
        self._sending = None

    def _is_acknowledged(self) -> bool:
        publisher = self._publisher
        return publisher is None or bool(publisher.wait_for_all_acked(load_rclpy().duration.Duration()))

    def _convert_one_by_one(self, payloads: Sequence[bytes]) -> list[bytes]:
        converted = []
        for payload in payloads:
            try:
                converted.append(self.support.converter.to_cdr(payload))
            except SerializationError as error:
                self._report_once(f"dropped a message for {self.topic}: {error}")
        return converted

    def _report_once(self, text: str) -> None:
        # Reported once: the next errors are probably the same.
        if not self._is_reported:
            self._is_reported = True
            self._own.report(Level.WARN, text)

    def _explain_mismatch(self, event: Any) -> None:
        policy = name_policy(event)
        advice = (
            "it requests earlier messages, but this publisher keeps none; subscribe with durability volatile"
            if policy == "durability"
            else f"it requests a different {policy} than this publisher offers; change its quality of service"
        )
        self._own.report_from_thread(
            Level.WARN,
            f"a subscriber receives nothing on {self.topic}: {advice} (ros2 topic info --verbose "
            f"{self.topic})",
        )
