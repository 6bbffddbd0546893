"""actionlib.SimpleActionServer: one goal at a time; a new goal preempts the previous one."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from typing import Any

from rostether.rospy.actionlib.action_server import ActionServer
from rostether.rospy.actionlib.action_types import GoalStatus
from rostether.rospy.actionlib.server_goal import ServerGoalHandle
from rostether.rospy.client.logs import logdebug, logerr, logwarn
from rostether.rospy.client.shutdown import is_shutdown

# How often the thread that executes goals checks for a shutdown.
_POLL_S = 0.1

_PREEMPTED = "This goal was canceled because another goal was received by the simple action server"
_ACCEPTED = "This goal has been accepted by the simple action server"


class SimpleActionServer:
    """A server that runs `execute_cb(goal)` in its own thread, or else returns goals from `accept_new_goal`.

    A thread acquires the lock of `action_server` before `lock`, never after it.
    """

    def __init__(
        self,
        name: str,
        ActionSpec: Any,
        execute_cb: Callable[[Any], object] | None = None,
        auto_start: bool = True,
    ) -> None:
        self.execute_callback = execute_cb
        self.goal_callback: Callable[[], object] | None = None
        self.preempt_callback: Callable[[], object] | None = None
        self.new_goal = False
        self.preempt_request = False
        self.new_goal_preempt_request = False
        self.need_to_terminate = False
        self.lock = threading.RLock()
        self.execute_condition = threading.Condition(self.lock)
        self.current_goal = ServerGoalHandle()
        self.next_goal = ServerGoalHandle()
        self.action_server = ActionServer(
            name, ActionSpec, self.internal_goal_callback, self.internal_preempt_callback, auto_start
        )
        self.execute_thread: threading.Thread | None = None
        if execute_cb is not None:
            # Not a daemon thread, so that a program continues to serve after its main function.
            self.execute_thread = threading.Thread(target=self._execute_goals, name=f"actionlib {name}")
            self.execute_thread.start()

    def start(self) -> None:
        """Start to receive goals if `auto_start` is False."""
        self.action_server.start()

    def accept_new_goal(self) -> Any:
        """Accept and return the newest goal, or None if there is none; cancel the previous goal."""
        with self.action_server.lock, self.lock:
            if not self.new_goal or self.next_goal.get_goal() is None:
                logerr("Attempting to accept the next goal when a new goal is not available")
                return None
            if self.is_active() and self.current_goal != self.next_goal:
                self.current_goal.set_canceled(None, _PREEMPTED)
            self.current_goal = self.next_goal
            self.new_goal = False
            self.preempt_request = self.new_goal_preempt_request
            self.new_goal_preempt_request = False
            self.current_goal.set_accepted(_ACCEPTED)
            return self.current_goal.get_goal()

    def is_new_goal_available(self) -> bool:
        """Return whether a goal is waiting to be accepted."""
        return self.new_goal

    def is_preempt_requested(self) -> bool:
        """Return whether the current goal should be canceled."""
        return self.preempt_request

    def is_active(self) -> bool:
        """Return whether a goal is active."""
        if self.current_goal.get_goal() is None:
            return False
        return self.current_goal.get_goal_status().status in (GoalStatus.ACTIVE, GoalStatus.PREEMPTING)

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """End the current goal as done."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_succeeded(result, text)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """End the current goal as failed."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_aborted(result, text)

    def set_preempted(self, result: Any = None, text: str = "") -> None:
        """End the current goal as canceled."""
        with self.action_server.lock, self.lock:
            self.current_goal.set_canceled(result, text)

    def publish_feedback(self, feedback: Any) -> None:
        """Publish feedback on the current goal."""
        self.current_goal.publish_feedback(feedback)

    def get_default_result(self) -> Any:
        """Return an empty result."""
        return self.action_server.ActionResultType()

    def register_goal_callback(self, cb: Callable[[], object]) -> None:
        """Set a function to call when a goal arrives; it has no effect with `execute_cb`."""
        if self.execute_callback is not None:
            logwarn(
                "Cannot call SimpleActionServer.register_goal_callback() because an executeCallback exists. "
                "Not going to register it."
            )
        else:
            self.goal_callback = cb

    def register_preempt_callback(self, cb: Callable[[], object]) -> None:
        """Set a function to call when the current goal should be canceled."""
        self.preempt_callback = cb

    def internal_goal_callback(self, goal: ServerGoalHandle) -> None:
        """Store a goal as the next one, unless it is older than the current ones."""
        with self.execute_condition:
            try:
                self._store_goal(goal)
            except Exception as error:  # noqa: BLE001 - a program's callback must not end the server
                logerr("SimpleActionServer.internal_goal_callback - exception %s", error)

    def internal_preempt_callback(self, preempt: ServerGoalHandle) -> None:
        """Handle a request to cancel a goal."""
        with self.lock:
            if preempt == self.current_goal:
                self._request_preemption()
            elif preempt == self.next_goal:
                self.new_goal_preempt_request = True

    def _store_goal(self, goal: ServerGoalHandle) -> None:
        known = [each for each in (self.current_goal, self.next_goal) if each.get_goal() is not None]
        if any(goal.get_goal_id().stamp < each.get_goal_id().stamp for each in known):
            goal.set_canceled(None, _PREEMPTED)
            return
        if self.next_goal.get_goal() is not None and self.next_goal != self.current_goal:
            self.next_goal.set_canceled(None, _PREEMPTED)
        self.next_goal = goal
        self.new_goal = True
        self.new_goal_preempt_request = False
        if self.is_active():
            self._request_preemption()
        if self.goal_callback is not None:
            self.goal_callback()
        self.execute_condition.notify()

    def _request_preemption(self) -> None:
        logdebug("Requesting preemption of the current goal")
        self.preempt_request = True
        if self.preempt_callback is not None:
            self.preempt_callback()

    def _execute_goals(self) -> None:
        while not (is_shutdown() or self.need_to_terminate):
            if self.is_active():
                logerr("Should never reach this code with an active goal")
                return
            if self.is_new_goal_available() and (goal := self.accept_new_goal()) is not None:
                self._execute(goal)
            with self.execute_condition:
                if not self.new_goal:
                    self.execute_condition.wait(_POLL_S)

    def _execute(self, goal: Any) -> None:
        assert self.execute_callback is not None
        try:
            self.execute_callback(goal)
            if self.is_active():
                logwarn(
                    "Your executeCallback did not set the goal to a terminal status. This is a bug in your "
                    "ActionServer implementation. Fix your code! For now, the ActionServer will set this "
                    "goal to aborted"
                )
                self.set_aborted(None, "No terminal state was set.")
        except Exception as error:  # noqa: BLE001 - an error in a callback ends the goal, not the server
            logerr("Exception in your execute callback: %s\n%s", error, traceback.format_exc())
            self.set_aborted(None, f"Exception in execute callback: {error}")
