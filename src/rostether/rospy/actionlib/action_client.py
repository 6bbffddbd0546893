"""actionlib.ActionClient: sends goals, and follows the status, result and feedback of each."""

from __future__ import annotations

import itertools
import threading
import time
import weakref
from collections.abc import Callable
from typing import Any

from rostether.rospy.actionlib.action_types import ActionClasses, GoalID, GoalStatusArray
from rostether.rospy.actionlib.client_goal import ClientGoalHandle, FollowedGoal
from rostether.rospy.client.message import Message
from rostether.rospy.client.names import get_caller_id, remap_name
from rostether.rospy.client.parameters import get_param
from rostether.rospy.client.publisher import Publisher
from rostether.rospy.client.ros_time import Duration, Time, get_rostime
from rostether.rospy.client.shutdown import is_shutdown
from rostether.rospy.client.stamps import Duration as AnyDuration
from rostether.rospy.client.subscriber import Subscriber

# As in actionlib.
DEFAULT_QUEUE_SIZE = 10
_POLL_S = 0.01

_numbers = itertools.count(1)


class ActionClient:
    """A client of the action in a namespace.

    Publishes `goal` and `cancel`, and subscribes to `status`, `result` and `feedback`.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        parts = ActionClasses.of(ActionSpec)
        self.ns = ns
        self.ActionSpec = ActionSpec
        self.ActionGoal: Any = parts.goal
        self.ActionResult = parts.result
        self.ActionFeedback = parts.feedback
        self.last_status_msg: Any = None
        self._goals: weakref.WeakValueDictionary[str, FollowedGoal] = weakref.WeakValueDictionary()
        self._lock = threading.RLock()
        out_size = queue_size("actionlib_client_pub_queue_size") or DEFAULT_QUEUE_SIZE
        in_size = queue_size("actionlib_client_sub_queue_size")
        name = remap_name(ns)
        self.pub_goal = Publisher(f"{name}/goal", parts.goal, queue_size=out_size)
        self.pub_cancel = Publisher(f"{name}/cancel", GoalID, queue_size=out_size)
        self.status_sub = Subscriber(
            f"{name}/status", GoalStatusArray, self._handle_statuses, queue_size=in_size
        )
        self.result_sub = Subscriber(f"{name}/result", parts.result, self._handle_result, queue_size=in_size)
        self.feedback_sub = Subscriber(
            f"{name}/feedback", parts.feedback, self._handle_feedback, queue_size=in_size
        )

    def stop(self) -> None:
        """Leave the action's topics."""
        for endpoint in (self.pub_goal, self.pub_cancel, self.status_sub, self.result_sub, self.feedback_sub):
            endpoint.unregister()

    def send_goal(
        self,
        goal: Message,
        transition_cb: Callable[[ClientGoalHandle], object] | None = None,
        feedback_cb: Callable[[ClientGoalHandle, Any], object] | None = None,
    ) -> ClientGoalHandle:
        """Send a goal; the client follows it as long as the program keeps the handle.

        `transition_cb` is called for every CommState, `feedback_cb` for the server's feedback.
        """
        handle = self.follow(goal, transition_cb, feedback_cb)
        self.pub_goal.publish(handle.comm_state_machine.action_goal)
        return handle

    def follow(
        self,
        goal: Message,
        transition_cb: Callable[[ClientGoalHandle], object] | None,
        feedback_cb: Callable[[ClientGoalHandle, Any], object] | None,
    ) -> ClientGoalHandle:
        """Return a handle to a goal that is sent afterwards, because the server may answer immediately."""
        stamp = Time.now()
        goal_id = GoalID(id=f"{get_caller_id()}-{next(_numbers)}-{stamp.to_sec():.3f}", stamp=stamp)
        action_goal = self.ActionGoal(goal_id=goal_id, goal=goal)
        action_goal.header.stamp = get_rostime()
        followed = FollowedGoal(action_goal, transition_cb, feedback_cb, self.pub_cancel.publish)
        with self._lock:
            self._goals[followed.id] = followed
        return ClientGoalHandle(followed)

    def cancel_all_goals(self) -> None:
        """Ask the server to cancel every goal, of any client."""
        self.pub_cancel.publish(GoalID())

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to cancel the goals that were sent at or before `time`."""
        self.pub_cancel.publish(GoalID(stamp=time))

    def wait_for_server(self, timeout: Any = 0.0) -> bool:
        """Wait until a server is connected; return False after `timeout` (zero: no limit) or shutdown."""
        limit = as_duration(timeout)
        deadline = get_rostime() + limit
        while not is_shutdown():
            if self._is_connected():
                return True
            if limit and get_rostime() >= deadline:
                return False
            time.sleep(_POLL_S)
        return False

    wait_for_action_server_to_start = wait_for_server

    def _is_connected(self) -> bool:
        status = self.last_status_msg
        if status is None:
            return False
        server = status._connection_header["callerid"]
        endpoints: tuple[Any, ...] = (self.pub_goal, self.pub_cancel, self.result_sub, self.feedback_sub)
        return all(each.impl is not None and each.impl.has_connection(server) for each in endpoints)

    def _handle_statuses(self, message: Any) -> None:
        self.last_status_msg = message
        statuses = {status.goal_id.id: status for status in reversed(message.status_list)}
        with self._lock:
            goals = list(self._goals.values())
        for goal in goals:
            goal.note_status(statuses.get(goal.id))

    def _handle_result(self, message: Any) -> None:
        if (goal := self._goal_of(message)) is not None:
            goal.note_result(message)

    def _handle_feedback(self, message: Any) -> None:
        if (goal := self._goal_of(message)) is not None:
            goal.note_feedback(message)

    def _goal_of(self, message: Any) -> FollowedGoal | None:
        with self._lock:
            return self._goals.get(message.status.goal_id.id)


def queue_size(parameter: str) -> int | None:
    """Return the size of a queue from a parameter; None if it is not a positive number."""
    size = get_param(parameter, -1)
    return size if isinstance(size, int) and size > 0 else None


def as_duration(value: Any) -> Any:
    """Return seconds or a duration as a duration."""
    return value if isinstance(value, AnyDuration) else Duration.from_sec(float(value))
