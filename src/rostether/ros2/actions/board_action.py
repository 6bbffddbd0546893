"""Offers an action of ROS 1, which consists of topics, as a ROS 2 action; its server is a board or a node.

    ROS 2 action client  --  Ros2ActionServer  --  goal, cancel, feedback, result, status  --  the board

A goal's id of 16 bytes is a string of 32 digits in ROS 1. The board's messages have the form of ROS 1; goals,
results and feedback are converted between this form and that of ROS 2.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from typing import Final

from rostether.graph.ports import Graph
from rostether.ros2.actions.ros1_form import (
    ActionForms,
    GoalId,
    Ros1Status,
    after_header,
    read_status,
    read_statuses,
    write_header,
)
from rostether.ros2.actions.server import Ros2ActionServer
from rostether.ros2.actions.types import GoalStatus
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types

# A board on a slow line receives a goal within this time; after that, its status must list the goal.
LOST_AFTER_S: Final = 5.0

# The final states of ROS 1, and their equivalents in ROS 2; a rejected goal is aborted.
_FINAL: Final[dict[int, GoalStatus]] = {
    Ros1Status.PREEMPTED: GoalStatus.CANCELED,
    Ros1Status.SUCCEEDED: GoalStatus.SUCCEEDED,
    Ros1Status.RECALLED: GoalStatus.CANCELED,
}


class BoardAction:
    """One action, of type `action_type` as `package/Name`.

    `on_goals` and `on_cancels` receive the messages for the board. `types` has the types of the boards'
    graph.
    """

    def __init__(self, action: str, action_type: str, types: Ros2Types) -> None:
        self.action = action
        self.action_type = action_type
        self.on_goals: Callable[[Sequence[bytes]], object] | None = None
        self.on_cancels: Callable[[Sequence[bytes]], object] | None = None
        self._types = types
        self._clock = asyncio.get_running_loop().time
        self._graph: Graph | None = None
        self._server: Ros2ActionServer | None = None
        # The active goals by their id strings, and their send times.
        self._sent_s: dict[str, float] = {}
        self._canceled: set[str] = set()

    async def open(self, graph: Graph, types: NativeTypes) -> None:
        """Offer the action on a node with native ROS 2 types.

        Raises InvalidNameError, GraphError, DefinitionError.
        """
        self._graph = graph
        self._forms = forms = ActionForms(self.action_type, self._types, types)
        server = Ros2ActionServer(
            self.action,
            forms.types,
            empty_result=forms.empty_result,
            on_goal=self._send_goal,
            on_cancel=self._send_cancel,
        )
        await server.open(graph)
        self._server = server

    async def close(self) -> None:
        """Abort the active goals, and stop offering the action. Idempotent."""
        server, self._server = self._server, None
        if server is not None:
            await server.close()

    def handle_feedback(self, payloads: Sequence[bytes]) -> None:
        """Publish the feedback of goals in progress."""
        if self._server is None:
            return
        for payload in payloads:
            text, _, content = read_status(payload, after_header(payload))
            if text in self._sent_s:
                feedback = self._forms.to_native("Feedback", payload[content:])
                self._server.feedback(bytes.fromhex(text), feedback)

    def handle_results(self, payloads: Sequence[bytes]) -> None:
        """End goals with their results."""
        for payload in payloads:
            text, status, content = read_status(payload, after_header(payload))
            if text in self._sent_s:
                # Preempted by another goal, not by its own client.
                is_replaced = status == Ros1Status.PREEMPTED and text not in self._canceled
                final = GoalStatus.ABORTED if is_replaced else _FINAL.get(status, GoalStatus.ABORTED)
                self._finish(text, final, self._forms.to_native("Result", payload[content:]))

    def handle_statuses(self, payloads: Sequence[bytes]) -> None:
        """Abort the goals that the board no longer knows, because it was reset."""
        listed = read_statuses(payloads[-1])
        old = [text for text, sent_s in self._sent_s.items() if self._clock() - sent_s > LOST_AFTER_S]
        for text in old:
            if text not in listed:
                self._finish(text, GoalStatus.ABORTED, None)

    def _send_goal(self, goal_id: bytes, payload: bytes) -> None:
        assert self._graph is not None
        text, now = goal_id.hex(), self._graph.now()
        self._sent_s[text] = self._clock()
        if self.on_goals is not None:
            ros1_id = GoalId((now.secs, now.nsecs), text).write()
            self.on_goals([write_header(now) + ros1_id + self._forms.to_ros1("Goal", payload)])

    def _send_cancel(self, goal_id: bytes) -> None:
        self._canceled.add(goal_id.hex())
        if self.on_cancels is not None:
            self.on_cancels([GoalId((0, 0), goal_id.hex()).write()])

    def _finish(self, text: str, status: GoalStatus, result: bytes | None) -> None:
        del self._sent_s[text]
        self._canceled.discard(text)
        if self._server is not None:
            self._server.finish(bytes.fromhex(text), status, result)
