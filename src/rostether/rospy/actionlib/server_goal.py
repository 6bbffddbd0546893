"""A goal in an action server: its status, and the program's handle to it."""

from __future__ import annotations

import threading
from typing import Any, Protocol

from rostether.rospy.actionlib.action_types import GoalID, GoalStatus
from rostether.rospy.actionlib.goal_ids import GoalIDGenerator
from rostether.rospy.client.logs import logdebug, logerr
from rostether.rospy.client.ros_time import Time

_CANCELLED = {
    GoalStatus.PENDING: GoalStatus.RECALLED,
    GoalStatus.RECALLING: GoalStatus.RECALLED,
    GoalStatus.ACTIVE: GoalStatus.PREEMPTED,
    GoalStatus.PREEMPTING: GoalStatus.PREEMPTED,
}
_ACCEPTED = {GoalStatus.PENDING: GoalStatus.ACTIVE, GoalStatus.RECALLING: GoalStatus.PREEMPTING}
_REJECTED = {GoalStatus.PENDING: GoalStatus.REJECTED, GoalStatus.RECALLING: GoalStatus.REJECTED}
_CANCEL_REQUESTED = {GoalStatus.PENDING: GoalStatus.RECALLING, GoalStatus.ACTIVE: GoalStatus.PREEMPTING}


class ServedGoal:
    """A goal in the list of a server; without `goal`, a cancel request that arrived before its goal."""

    def __init__(self, goal_id: Any = None, status: int = GoalStatus.PENDING, goal: Any = None) -> None:
        self.goal = goal
        self.status: Any = GoalStatus(goal_id=goal_id or goal.goal_id, status=status)
        # Zero until the goal ends; then it stays in the list for some time.
        self.ended_at = Time()
        if not self.status.goal_id.id:
            self.status.goal_id = GoalIDGenerator().generate_ID()
        if goal is not None and not self.status.goal_id.stamp:
            self.status.goal_id.stamp = Time.now()


class GoalPublisher(Protocol):
    """The part of a server that the handle of a goal uses; a change of a status holds `lock`."""

    lock: threading.RLock
    ActionResultType: Any

    def publish_status(self) -> None:
        """Publish the list of goals."""

    def publish_result(self, status: Any, result: Any) -> None:
        """Publish the result of a goal, and the list of goals."""

    def publish_feedback(self, status: Any, feedback: Any) -> None:
        """Publish the progress of a goal."""


class ServerGoalHandle:
    """A program's handle to a goal; an empty handle does nothing."""

    def __init__(
        self, status_tracker: ServedGoal | None = None, action_server: GoalPublisher | None = None
    ) -> None:
        self.status_tracker = status_tracker
        self.action_server = action_server
        self.goal: Any = None if status_tracker is None else status_tracker.goal

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ServerGoalHandle) or self.goal is None or other.goal is None:
            return False
        return bool(self.get_goal_id().id == other.get_goal_id().id)

    def __hash__(self) -> int:
        return hash(self.get_goal_id().id)

    def get_default_result(self) -> Any:
        """Return an empty result, or None for an empty handle."""
        return None if self.action_server is None else self.action_server.ActionResultType()

    def get_goal(self) -> Any:
        """Return the goal, or None for an empty handle."""
        return None if self.goal is None else self.goal.goal

    def get_goal_id(self) -> Any:
        """Return the goal's GoalID; an empty one for an empty handle."""
        found = self._found("get a goal id")
        return GoalID() if found is None else found[1].status.goal_id

    def get_goal_status(self) -> Any:
        """Return the goal's GoalStatus; an empty one for an empty handle."""
        found = self._found("get goal status")
        return GoalStatus() if found is None else found[1].status

    def set_accepted(self, text: str = "") -> None:
        """Start work on the goal: ACTIVE, or PREEMPTING after a cancel request."""
        self._change(_ACCEPTED, "an active state, the goal must be in a pending or recalling state", text)

    def set_canceled(self, result: Any = None, text: str = "") -> None:
        """End the goal as canceled: RECALLED or PREEMPTED."""
        requirement = (
            "a cancelled state, the goal must be in a pending, recalling, active, or preempting state"
        )
        self._end(_CANCELLED, requirement, result, text)

    def set_rejected(self, result: Any = None, text: str = "") -> None:
        """Refuse the goal."""
        requirement = "a rejected state, the goal must be in a pending or recalling state"
        self._end(_REJECTED, requirement, result, text)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """End the goal as failed."""
        requirement = "an aborted state, the goal must be in a preempting or active state"
        self._end(_from_work_to(GoalStatus.ABORTED), requirement, result, text)

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """End the goal as done."""
        requirement = "a succeeded state, the goal must be in a preempting or active state"
        self._end(_from_work_to(GoalStatus.SUCCEEDED), requirement, result, text)

    def publish_feedback(self, feedback: Any) -> None:
        """Publish feedback."""
        if (found := self._found("publish feedback")) is not None:
            found[0].publish_feedback(found[1].status, feedback)

    def set_cancel_requested(self) -> bool:
        """Record a cancel request; return False if that does not change the status."""
        found = self._found("cancel")
        if found is None:
            return False
        server, goal = found
        with server.lock:
            status = _CANCEL_REQUESTED.get(goal.status.status)
            if status is None:
                return False
            goal.status.status = status
            server.publish_status()
            return True

    def _change(self, transitions: dict[int, int], requirement: str, text: str) -> ServedGoal | None:
        found = self._found("set status")
        if found is None:
            return None
        server, goal = found
        with server.lock:
            status = transitions.get(goal.status.status)
            if status is None:
                logerr("To transition to %s, it is currently in state: %d", requirement, goal.status.status)
                return None
            logdebug("Goal %s: %s", goal.status.goal_id.id, GoalStatus.to_string(status))
            goal.status.status = status
            goal.status.text = text
            if transitions is _ACCEPTED:
                server.publish_status()
            return goal

    def _end(self, transitions: dict[int, int], requirement: str, result: Any, text: str) -> None:
        server = self.action_server
        if server is None:
            self._found("set status")
            return
        with server.lock:
            goal = self._change(transitions, requirement, text)
            if goal is not None:
                goal.ended_at = Time.now()
                server.publish_result(goal.status, self.get_default_result() if result is None else result)

    def _found(self, what: str) -> tuple[GoalPublisher, ServedGoal] | None:
        if self.goal is None or self.action_server is None or self.status_tracker is None:
            logerr("Attempt to %s on an uninitialized ServerGoalHandle", what)
            return None
        return self.action_server, self.status_tracker


def _from_work_to(status: int) -> dict[int, int]:
    return {GoalStatus.ACTIVE: status, GoalStatus.PREEMPTING: status}
