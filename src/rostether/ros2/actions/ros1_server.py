"""Offers a ROS 2 action in ROS 1, as the topics of an actionlib server.

    actionlib client  --  goal, cancel, feedback, result, status  --  GoalCall  --  ROS 2 action server

Each goal of ROS 1 is one goal of ROS 2, with a new id.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import AsyncExitStack
from typing import Final

from rostether.errors import RostetherError, ServiceCallError
from rostether.graph.ports import Graph, Publisher
from rostether.mechanisms.tasks import cancel_all, start_task
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.ros2.actions.ros1_form import (
    CANCEL,
    FEEDBACK,
    GOAL,
    RESULT,
    STATUS,
    ActionForms,
    GoalId,
    Ros1Status,
    after_header,
    type_of_part,
    write_header,
    write_statuses,
)
from rostether.ros2.actions.server import MAX_GOALS
from rostether.ros2.actions.types import GoalCall, GoalStatus

# How often actionlib's servers publish the status, and how long they list a goal that has ended.
STATUS_INTERVAL_S: Final = 0.2
LISTED_S: Final = 5.0

# A server that does not answer a cancel request must not delay the end of the relay.
CLOSE_TIMEOUT_S: Final = 1.0

_FINAL: Final = {
    GoalStatus.SUCCEEDED: Ros1Status.SUCCEEDED,
    GoalStatus.CANCELED: Ros1Status.PREEMPTED,
}


class _Goal:
    """One goal, from its arrival until `LISTED_S` after its end."""

    def __init__(self, goal_id: GoalId, call: GoalCall) -> None:
        self.id = goal_id
        self.call = call
        self.status = Ros1Status.PENDING
        self.text = ""
        self.is_canceled = False
        self.ended_s: float | None = None
        self.running: asyncio.Task[None] | None = None

    def status_bytes(self) -> bytes:
        return self.id.status(self.status, self.text)


class Ros1ActionServer:
    """One action, of type `action_type` as `package/Name`.

    `ros1` is a node of ROS 1, and `native` a node that uses native ROS 2 types. `registry` has the types of
    ROS 1.
    """

    def __init__(
        self,
        action: str,
        action_type: str,
        forms: ActionForms,
        *,
        ros1: Graph,
        native: Graph,
        registry: Registry,
    ) -> None:
        self.action = action
        self._action_type = action_type
        self._forms = forms
        self._ros1 = ros1
        self._native = native
        self._registry = registry
        self._clock = asyncio.get_running_loop().time
        self._goals: dict[str, _Goal] = {}
        self._canceling: set[asyncio.Task[None]] = set()
        self._count = 0
        self._stack = AsyncExitStack()

    async def open(self) -> None:
        """Offer the action.

        Raises InvalidNameError, GraphError, DefinitionError; then nothing remains open.
        """
        try:
            self._feedback = await self._advertise(FEEDBACK)
            self._result = await self._advertise(RESULT)
            self._status = await self._advertise(STATUS, latch=True)
            for part, handle in ((CANCEL, self._handle_cancels), (GOAL, self._handle_goals)):
                subscriber = await self._ros1.subscribe(self.action + part[0], self._type(part), handle)
                self._stack.push_async_callback(subscriber.close)
        except BaseException:
            await self._stack.aclose()
            raise
        reporting = asyncio.create_task(self._report_statuses())
        self._stack.callback(reporting.cancel)

    async def close(self) -> None:
        """Cancel the active goals, and stop offering the action. Idempotent."""
        active = [goal for goal in self._goals.values() if goal.ended_s is None]
        for goal in active:
            self._cancel(goal)
        running = [goal.running for goal in active if goal.running is not None]
        if running:
            await asyncio.wait(running, timeout=CLOSE_TIMEOUT_S)
        await cancel_all(*running, *self._canceling)
        for goal in active:
            if goal.ended_s is None:
                self._end(goal, Ros1Status.ABORTED, "its server is no longer reachable", None)
        await self._stack.aclose()

    async def _advertise(self, part: tuple[str, str], *, latch: bool = False) -> Publisher:
        publisher = await self._ros1.advertise(self.action + part[0], self._type(part), latch=latch)
        self._stack.push_async_callback(publisher.close)
        return publisher

    def _type(self, part: tuple[str, str]) -> MessageType:
        return self._registry.message_type(type_of_part(part, self._action_type))

    def _handle_goals(self, payloads: Sequence[bytes]) -> None:
        for payload in payloads:
            goal_id, content = GoalId.read(payload, after_header(payload))
            if goal_id.text not in self._goals:
                self._begin(self._complete(goal_id), payload[content:])
        self._publish_statuses()

    def _complete(self, goal_id: GoalId) -> GoalId:
        """Return the id of a new goal; as in actionlib, an empty one gets a text and a stamp."""
        now = self._ros1.now()
        self._count += 1
        text = goal_id.text or f"{self._ros1.node_name}-{self._count}-{now.secs}.{now.nsecs:09d}"
        return GoalId(goal_id.stamp if any(goal_id.stamp) else (now.secs, now.nsecs), text)

    def _begin(self, goal_id: GoalId, content: bytes) -> None:
        goal = _Goal(goal_id, GoalCall(self._native, self.action, self._forms.types))
        if len(self._goals) >= MAX_GOALS:
            self._end(goal, Ros1Status.REJECTED, f"at most {MAX_GOALS} goals at once are relayed", None)
            return
        self._goals[goal_id.text] = goal
        goal.running = asyncio.create_task(self._run(goal, content))

    async def _run(self, goal: _Goal, content: bytes) -> None:
        def accepted() -> None:
            goal.status = Ros1Status.ACTIVE
            self._publish_statuses()
            if goal.is_canceled:
                self._cancel(goal)

        def feed(payload: bytes) -> None:
            feedback = self._forms.to_ros1("Feedback", payload)
            self._feedback.publish_raw([write_header(self._ros1.now()) + goal.status_bytes() + feedback])

        try:
            payload = self._forms.to_native("Goal", content)
            status, result = await goal.call.run(payload, feed, accepted)
        except RostetherError as error:
            is_rejected = isinstance(error, ServiceCallError) and goal.status is Ros1Status.PENDING
            final = Ros1Status.REJECTED if is_rejected else Ros1Status.ABORTED
            self._end(goal, final, str(error), None)
        else:
            self._end(goal, _FINAL.get(status, Ros1Status.ABORTED), "", result)

    def _end(self, goal: _Goal, status: Ros1Status, text: str, result: bytes | None) -> None:
        goal.status, goal.text, goal.ended_s = status, text, self._clock()
        content = self._forms.to_ros1("Result", self._forms.empty_result if result is None else result)
        self._publish_statuses()
        self._result.publish_raw([write_header(self._ros1.now()) + goal.status_bytes() + content])

    def _handle_cancels(self, payloads: Sequence[bytes]) -> None:
        for payload in payloads:
            wanted, _ = GoalId.read(payload)
            for goal in self._goals.values():
                is_for_all = not wanted.text and not any(wanted.stamp)
                is_older = any(wanted.stamp) and goal.id.stamp <= wanted.stamp
                if goal.ended_s is None and (is_for_all or is_older or goal.id.text == wanted.text):
                    self._cancel(goal)
        self._publish_statuses()

    def _cancel(self, goal: _Goal) -> None:
        goal.is_canceled = True
        if goal.status is Ros1Status.ACTIVE:
            goal.status = Ros1Status.PREEMPTING
            start_task(self._canceling, self._ask_to_cancel(goal))

    async def _ask_to_cancel(self, goal: _Goal) -> None:
        try:
            await goal.call.cancel()
        except RostetherError as error:
            goal.text = f"the cancel request failed: {error}"

    async def _report_statuses(self) -> None:
        while True:
            now_s = self._clock()
            for text, goal in list(self._goals.items()):
                if goal.ended_s is not None and now_s - goal.ended_s > LISTED_S:
                    del self._goals[text]
            self._publish_statuses()
            await asyncio.sleep(STATUS_INTERVAL_S)

    def _publish_statuses(self) -> None:
        statuses = [goal.status_bytes() for goal in self._goals.values()]
        self._status.publish_raw([write_statuses(self._ros1.now(), statuses)])
