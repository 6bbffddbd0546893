"""A goal in an action client: its state, and the program's handle to it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rostether.rospy.actionlib.action_types import GoalID, GoalStatus
from rostether.rospy.actionlib.comm_states import ENDED, TRANSITIONS, CommState
from rostether.rospy.client.logs import logdebug, logerr, logwarn

# The statuses that a server sends; the client itself sets LOST.
_KNOWN_STATUSES = range(GoalStatus.PENDING, GoalStatus.RECALLED + 1)

# In these states, the list of the server may lack the goal.
_MAY_BE_UNKNOWN = (CommState.WAITING_FOR_GOAL_ACK, CommState.WAITING_FOR_RESULT)


class FollowedGoal:
    """The state machine of a goal; callbacks run one at a time, in the thread that received the message."""

    def __init__(
        self,
        action_goal: Any,
        transition_cb: Callable[[ClientGoalHandle], object] | None,
        feedback_cb: Callable[[ClientGoalHandle, Any], object] | None,
        send_cancel: Callable[[Any], object],
    ) -> None:
        self.action_goal = action_goal
        self.state = CommState.WAITING_FOR_GOAL_ACK
        self.latest_goal_status: Any = GoalStatus(status=GoalStatus.PENDING)
        self.latest_result: Any = None
        self.mutex = threading.RLock()
        self._transition_cb = transition_cb
        self._feedback_cb = feedback_cb
        self._send_cancel = send_cancel

    @property
    def id(self) -> str:
        """The goal's id."""
        return str(self.action_goal.goal_id.id)

    def cancel(self) -> None:
        """Ask the server to cancel the goal."""
        with self.mutex:
            self._send_cancel(GoalID(id=self.id))
            if self.state != CommState.DONE:
                self.transition_to(CommState.WAITING_FOR_CANCEL_ACK)

    def note_status(self, status: Any) -> None:
        """Apply the goal's status in the list of the server; None if the goal is not listed."""
        with self.mutex:
            if self.state == CommState.DONE:
                return
            if status is not None:
                self.latest_goal_status = status
                self._follow(status.status)
            elif self.state not in _MAY_BE_UNKNOWN:
                self.latest_goal_status.status = GoalStatus.LOST
                self.transition_to(CommState.DONE)

    def note_result(self, action_result: Any) -> None:
        """Apply the result, which ends the goal."""
        with self.mutex:
            self.latest_goal_status = action_result.status
            self.latest_result = action_result
            if self.state == CommState.DONE:
                logerr("Got a result when we were already in the DONE state")
                return
            self._follow(action_result.status.status)
            self.transition_to(CommState.DONE)

    def note_feedback(self, action_feedback: Any) -> None:
        """Pass feedback to the callback."""
        if self._feedback_cb is not None and self.state != CommState.DONE:
            self._feedback_cb(ClientGoalHandle(self), action_feedback.feedback)

    def transition_to(self, state: int) -> None:
        """Enter a state."""
        logdebug("Goal %s: %s", self.id, CommState.to_string(state))
        self.state = state
        if self._transition_cb is not None:
            self._transition_cb(ClientGoalHandle(self))

    def _follow(self, status: int) -> None:
        if status not in _KNOWN_STATUSES:
            logerr("Got an unknown status from the ActionServer: %i", status)
            return
        states = TRANSITIONS[self.state].get(status)
        if states is None:
            logerr(
                "Invalid goal status transition from %s to %s",
                CommState.to_string(self.state),
                GoalStatus.to_string(status),
            )
            return
        for state in states:
            self.transition_to(state)


class ClientGoalHandle:
    """A program's handle to a goal that it has sent. A client follows a goal only while a handle exists."""

    def __init__(self, comm_state_machine: FollowedGoal) -> None:
        self.comm_state_machine = comm_state_machine

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and self._id == other._id

    def __hash__(self) -> int:
        return hash(self._id)

    @property
    def _id(self) -> str:
        return self.comm_state_machine.id

    def cancel(self) -> None:
        """Ask the server to cancel the goal."""
        self.comm_state_machine.cancel()

    def get_comm_state(self) -> int:
        """Return the CommState."""
        return self.comm_state_machine.state

    def get_goal_status(self) -> int:
        """Return the last status from the server, a constant of actionlib_msgs/GoalStatus."""
        return int(self.comm_state_machine.latest_goal_status.status)

    def get_goal_status_text(self) -> str:
        """Return the text of the server's last status."""
        return str(self.comm_state_machine.latest_goal_status.text)

    def get_result(self) -> Any:
        """Return the result, or None before the end."""
        latest = self.comm_state_machine.latest_result
        return None if latest is None else latest.result

    def get_terminal_state(self) -> int:
        """Return the final status of the goal, a constant of TerminalState; LOST before the end."""
        goal = self.comm_state_machine
        with goal.mutex:
            if goal.state != CommState.DONE:
                logwarn("Asking for the terminal state when we're in [%s]", CommState.to_string(goal.state))
            status = self.get_goal_status()
            if status in ENDED:
                return status
            logerr("Asking for a terminal state, but the goal status is %d", status)
            return int(GoalStatus.LOST)
