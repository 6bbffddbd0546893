"""actionlib.ActionServer: receives goals and cancel requests, and publishes the list of goals."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rostether.rospy.actionlib.action_client import queue_size
from rostether.rospy.actionlib.action_types import ActionClasses, GoalID, GoalStatus, GoalStatusArray
from rostether.rospy.actionlib.goal_ids import GoalIDGenerator
from rostether.rospy.actionlib.server_goal import ServedGoal, ServerGoalHandle
from rostether.rospy.client.logs import logdebug, logwarn
from rostether.rospy.client.names import remap_name
from rostether.rospy.client.parameters import get_param, has_param, search_param
from rostether.rospy.client.publisher import Publisher
from rostether.rospy.client.ros_time import Duration, Time, Timer
from rostether.rospy.client.shutdown import is_shutdown
from rostether.rospy.client.subscriber import Subscriber

# As in actionlib.
DEFAULT_QUEUE_SIZE = 50
DEFAULT_STATUS_HZ = 5.0

# As in actionlib: how long an ended goal stays in the list, so that its client receives its status.
DEFAULT_LISTED_S = 5.0

# The limit of goals and cancel requests in a list, because peers can send any number. At the limit, the
# oldest ended one is removed.
MAX_LISTED = 10_000

_CANCELLED_BEFORE = (
    "This goal handle was canceled by the action server because its timestamp is before the timestamp of the "
    "last cancel request"
)


def no_cancel(goal_handle: ServerGoalHandle) -> None:
    """Ignore a cancel request."""


class ActionServer:
    """A server of the action in a namespace.

    Subscribes to `goal` and `cancel`, and publishes `status`, `result` and `feedback`. Callbacks get a
    ServerGoalHandle, and run with the lock of the server.
    """

    def __init__(
        self,
        ns: str,
        ActionSpec: Any,
        goal_cb: Callable[[ServerGoalHandle], object],
        cancel_cb: Callable[[ServerGoalHandle], object] = no_cancel,
        auto_start: bool = True,
    ) -> None:
        parts = ActionClasses.of(ActionSpec)
        self.ns = ns
        self.ActionSpec = ActionSpec
        self.ActionGoal = parts.goal
        self.ActionResult: Any = parts.result
        self.ActionResultType: Any = parts.plain_result
        self.ActionFeedback: Any = parts.feedback
        self.goal_callback = goal_cb
        self.cancel_callback = cancel_cb
        self.auto_start = auto_start
        self.started = False
        self.lock = threading.RLock()
        self.status_list: list[ServedGoal] = []
        self.status_list_timeout: Any = Duration.from_sec(DEFAULT_LISTED_S)
        self.status_frequency = DEFAULT_STATUS_HZ
        self.status_timer: Timer | None = None
        self.last_cancel = Time()
        self.id_generator = GoalIDGenerator()
        self._endpoints: list[Publisher | Subscriber] = []
        if auto_start:
            logwarn(
                "You've passed in true for auto_start to the python action server, you should always pass "
                "in false to avoid race conditions."
            )
            self.start()

    def register_goal_callback(self, cb: Callable[[ServerGoalHandle], object]) -> None:
        """Set the function to call with new goals."""
        self.goal_callback = cb

    def register_cancel_callback(self, cancel_cb: Callable[[ServerGoalHandle], object]) -> None:
        """Set the function to call with goals that should be canceled."""
        self.cancel_callback = cancel_cb

    def start(self) -> None:
        """Join the action's topics."""
        with self.lock:
            self.initialize()
            self.started = True
            self.publish_status()

    def stop(self) -> None:
        """Leave the action's topics."""
        with self.lock:
            self.started = False
            if self.status_timer is not None:
                self.status_timer.shutdown()
            endpoints, self._endpoints = self._endpoints, []
        for endpoint in endpoints:
            endpoint.unregister()

    def initialize(self) -> None:
        """Create the publishers, the subscribers and the timer of the status list, for `start`."""
        name = remap_name(self.ns)
        size = queue_size("actionlib_server_pub_queue_size") or DEFAULT_QUEUE_SIZE
        self.status_pub = Publisher(f"{name}/status", GoalStatusArray, latch=True, queue_size=size)
        self.result_pub = Publisher(f"{name}/result", self.ActionResult, queue_size=size)
        self.feedback_pub = Publisher(f"{name}/feedback", self.ActionFeedback, queue_size=size)
        self.status_frequency = _status_hz(name)
        self.status_list_timeout = Duration.from_sec(
            get_param(f"{name}/status_list_timeout", DEFAULT_LISTED_S)
        )
        size_in = queue_size("actionlib_server_sub_queue_size")
        self.goal_sub = Subscriber(
            f"{name}/goal", self.ActionGoal, self.internal_goal_callback, queue_size=size_in
        )
        self.cancel_sub = Subscriber(
            f"{name}/cancel", GoalID, self.internal_cancel_callback, queue_size=size_in
        )
        self._endpoints = [
            self.goal_sub,
            self.cancel_sub,
            self.status_pub,
            self.feedback_pub,
            self.result_pub,
        ]
        if self.status_frequency > 0:
            self.status_timer = Timer(
                Duration.from_sec(1.0 / self.status_frequency), self.publish_status_async
            )

    def publish_result(self, status: Any, result: Any) -> None:
        """Publish the result of a goal, and the status list."""
        with self.lock:
            self._publish(self.result_pub, self.ActionResult(status=status, result=result))
            self.publish_status()

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """Publish the progress of a goal."""
        with self.lock:
            self._publish(self.feedback_pub, self.ActionFeedback(status=status, feedback=feedback))

    def publish_status_async(self, event: object) -> None:
        """Publish the status list; the timer calls this."""
        with self.lock:
            if self.started:
                self.publish_status()

    def publish_status(self) -> None:
        """Publish the status list, without goals that ended some time ago."""
        with self.lock:
            now = Time.now()
            limit = self.status_list_timeout
            self.status_list = [
                goal for goal in self.status_list if not goal.ended_at or goal.ended_at + limit >= now
            ]
            statuses = [goal.status for goal in self.status_list]
            self._publish(self.status_pub, GoalStatusArray(status_list=statuses))

    def _publish(self, publisher: Publisher, message: Any) -> None:
        message.header.stamp = Time.now()
        if not is_shutdown():
            publisher.publish(message)

    def internal_goal_callback(self, goal: Any) -> None:
        """Handle a goal."""
        with self.lock:
            if not self.started:
                return
            logdebug("The action server has received a new goal request")
            for known in self.status_list:
                if known.status.goal_id.id == goal.goal_id.id:
                    self._handle_repeated_goal(known)
                    return
            served = ServedGoal(goal=goal)
            self._list(served)
            handle = ServerGoalHandle(served, self)
            if Time() != goal.goal_id.stamp <= self.last_cancel:
                handle.set_canceled(None, _CANCELLED_BEFORE)
            else:
                self.goal_callback(handle)

    def internal_cancel_callback(self, goal_id: Any) -> None:
        """Handle a request to cancel one goal, all goals until a time, or all goals."""
        with self.lock:
            if not self.started:
                return
            logdebug("The action server has received a new cancel request")
            is_known = False
            for served in list(self.status_list):
                own_id = served.status.goal_id
                is_meant = own_id.id == goal_id.id
                is_known = is_known or is_meant
                is_before = bool(goal_id.stamp) and own_id.stamp <= goal_id.stamp
                is_for_all = not goal_id.id and not goal_id.stamp
                if (is_meant or is_before or is_for_all) and served.goal is not None:
                    handle = ServerGoalHandle(served, self)
                    if handle.set_cancel_requested():
                        self.cancel_callback(handle)
            if goal_id.id and not is_known:
                # The goal may arrive after its cancel request.
                early = ServedGoal(goal_id, GoalStatus.RECALLING)
                early.ended_at = Time.now()
                self._list(early)
            self.last_cancel = max(self.last_cancel, goal_id.stamp)

    def _handle_repeated_goal(self, known: ServedGoal) -> None:
        if known.status.status == GoalStatus.RECALLING:
            known.status.status = GoalStatus.RECALLED
            self.publish_result(known.status, self.ActionResultType())
        if known.goal is None:
            known.ended_at = Time.now()

    def _list(self, served: ServedGoal) -> None:
        if len(self.status_list) >= MAX_LISTED:
            oldest = next((goal for goal in self.status_list if goal.ended_at), None)
            if oldest is not None:
                self.status_list.remove(oldest)
        self.status_list.append(served)


def _status_hz(name: str) -> float:
    if has_param(f"{name}/status_frequency"):
        logwarn(
            "You're using the deprecated status_frequency parameter, please switch to "
            "actionlib_status_frequency."
        )
        return float(get_param(f"{name}/status_frequency", DEFAULT_STATUS_HZ))
    found = search_param("actionlib_status_frequency")
    return DEFAULT_STATUS_HZ if found is None else float(get_param(found, DEFAULT_STATUS_HZ))
