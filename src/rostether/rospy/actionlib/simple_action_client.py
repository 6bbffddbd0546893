"""actionlib.SimpleActionClient: one goal at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, ClassVar

from rostether.rospy.actionlib.action_client import ActionClient, as_duration
from rostether.rospy.actionlib.action_types import GoalStatus, name_of_state
from rostether.rospy.actionlib.client_goal import ClientGoalHandle
from rostether.rospy.actionlib.comm_states import CommState
from rostether.rospy.client.logs import logdebug, logerr
from rostether.rospy.client.message import Message
from rostether.rospy.client.names import resolve_name
from rostether.rospy.client.ros_time import get_rostime
from rostether.rospy.client.shutdown import is_shutdown

# The interval of the checks of ROS time, which may be simulated.
_POLL_S = 0.1


class SimpleGoalState:
    """The state of a SimpleActionClient's goal."""

    PENDING = 0
    ACTIVE = 1
    DONE = 2

    to_string: ClassVar = classmethod(name_of_state)


class SimpleActionClient:
    """A client with one goal at a time; a new goal replaces the old one. A timeout of zero means no limit."""

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.action_client = ActionClient(ns, ActionSpec)
        self.simple_state = SimpleGoalState.DONE
        self.gh: ClientGoalHandle | None = None
        self.done_condition = threading.Condition()
        self.done_cb: Callable[[int, Any], object] | None = None
        self.active_cb: Callable[[], object] | None = None
        self.feedback_cb: Callable[[Any], object] | None = None

    def wait_for_server(self, timeout: Any = 0.0) -> bool:
        """Wait until a server is connected; return False at the timeout."""
        return self.action_client.wait_for_server(timeout)

    def send_goal(
        self,
        goal: Message,
        done_cb: Callable[[int, Any], object] | None = None,
        active_cb: Callable[[], object] | None = None,
        feedback_cb: Callable[[Any], object] | None = None,
    ) -> None:
        """Send a goal; `done_cb` gets status and result, `active_cb` nothing, `feedback_cb` the feedback."""
        self.stop_tracking_goal()
        self.done_cb = done_cb
        self.active_cb = active_cb
        self.feedback_cb = feedback_cb
        self.simple_state = SimpleGoalState.PENDING
        self.gh = self.action_client.follow(goal, self._handle_transition, self._handle_feedback)
        self.action_client.pub_goal.publish(self.gh.comm_state_machine.action_goal)

    def send_goal_and_wait(
        self, goal: Message, execute_timeout: Any = 0.0, preempt_timeout: Any = 0.0
    ) -> int:
        """Send a goal, wait for its end, and return its status.

        After `execute_timeout`, cancels the goal and waits at most `preempt_timeout` for its end.
        """
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            logdebug("Canceling goal")
            self.cancel_goal()
            ended = self.wait_for_result(preempt_timeout)
            logdebug("Preempt %s within %s s", "finished" if ended else "didn't finish", preempt_timeout)
        return self.get_state()

    def wait_for_result(self, timeout: Any = 0.0) -> bool:
        """Wait for the goal's end; return False at the timeout."""
        if self.gh is None:
            logerr("Called wait_for_result when no goal exists")
            return False
        limit = as_duration(timeout)
        deadline = get_rostime() + limit
        with self.done_condition:
            while not is_shutdown() and self.simple_state != SimpleGoalState.DONE:
                wait_s = _POLL_S
                if limit.to_sec() > 0:
                    left_s = (deadline - get_rostime()).to_sec()
                    if left_s <= 0:
                        break
                    wait_s = min(wait_s, left_s)
                self.done_condition.wait(wait_s)
        return self.simple_state == SimpleGoalState.DONE

    def get_result(self) -> Any:
        """Return the result; None without a goal, or before its end."""
        if self.gh is None:
            logerr("Called get_result when no goal is running")
            return None
        return self.gh.get_result()

    def get_state(self) -> int:
        """Return the goal's status, a constant of actionlib_msgs/GoalStatus; LOST without a goal."""
        if self.gh is None:
            return int(GoalStatus.LOST)
        status = self.gh.get_goal_status()
        simplified = {GoalStatus.RECALLING: GoalStatus.PENDING, GoalStatus.PREEMPTING: GoalStatus.ACTIVE}
        return int(simplified.get(status, status))

    def get_goal_status_text(self) -> str:
        """Return the text of the server's last status of the goal."""
        if self.gh is None:
            logerr("Called get_goal_status_text when no goal is running")
            return "ERROR: Called get_goal_status_text when no goal is running"
        return self.gh.get_goal_status_text()

    def cancel_all_goals(self) -> None:
        """Ask the server to cancel every goal, of any client."""
        self.action_client.cancel_all_goals()

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to cancel the goals that were sent at or before `time`."""
        self.action_client.cancel_goals_at_and_before_time(time)

    def cancel_goal(self) -> None:
        """Ask the server to cancel this goal."""
        if self.gh is not None:
            self.gh.cancel()

    def stop_tracking_goal(self) -> None:
        """Stop following the goal; it is not canceled."""
        self.gh = None

    def _handle_transition(self, handle: ClientGoalHandle) -> None:
        if handle != self.gh:
            logerr("Got a transition callback on a goal handle that we're not tracking")
            return
        state = handle.get_comm_state()
        if state == CommState.DONE and self.simple_state != SimpleGoalState.DONE:
            self._end(handle)
        elif state == CommState.DONE:
            logerr("SimpleActionClient received DONE twice")
        elif state in (CommState.ACTIVE, CommState.PREEMPTING):
            if self.simple_state == SimpleGoalState.PENDING:
                self.simple_state = SimpleGoalState.ACTIVE
                if self.active_cb is not None:
                    self.active_cb()
            elif self.simple_state == SimpleGoalState.DONE:
                self._report_misfit(state)
        elif state == CommState.RECALLING and self.simple_state != SimpleGoalState.PENDING:
            self._report_misfit(state)

    def _end(self, handle: ClientGoalHandle) -> None:
        try:
            if self.done_cb is not None:
                self.done_cb(handle.get_goal_status(), handle.get_result())
        finally:
            with self.done_condition:
                # If done_cb has sent the next goal, that one is not done.
                if self.gh is None or self.gh == handle:
                    self.simple_state = SimpleGoalState.DONE
                self.done_condition.notify_all()

    def _handle_feedback(self, handle: ClientGoalHandle, feedback: Any) -> None:
        if self.gh is None:
            return
        if handle != self.gh:
            logerr("Got a feedback callback on a goal handle that we're not tracking")
        elif self.feedback_cb is not None:
            self.feedback_cb(feedback)

    def _report_misfit(self, state: int) -> None:
        logerr(
            "Received comm state %s when in simple state %s with SimpleActionClient in NS %s",
            CommState.to_string(state),
            SimpleGoalState.to_string(self.simple_state),
            resolve_name(self.action_client.ns),
        )
