"""Offers an action: receives goals, and reports their feedback, status and results."""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Callable
from contextlib import AsyncExitStack
from typing import Final

import msgspec
from msgspec import field

from rostether.errors import UnknownNameError
from rostether.graph.ports import Graph, Publisher
from rostether.ros2.actions.types import (
    CANCEL_SERVICE,
    FEEDBACK_TOPIC,
    GET_RESULT_SERVICE,
    ID_BYTES,
    SEND_GOAL_SERVICE,
    STAMP,
    STATUS_TOPIC,
    ActionTypes,
    CancelCode,
    GoalStatus,
)

# The limit of active goals and of results kept for late callers; a robot has a few.
MAX_GOALS: Final = 200

# The number of iterations of the event loop until an answer is sent to its caller.
_TURNS_TO_ANSWER: Final = 4

_NO_ID = bytes(ID_BYTES)
_NO_STAMP = (0, 0)
_FINISHED = (GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED)
_COUNT = struct.Struct("<I")


class _Goal(msgspec.Struct):
    stamp: tuple[int, int]
    status: GoalStatus = GoalStatus.EXECUTING
    result: asyncio.Future[bytes] = field(default_factory=lambda: asyncio.get_running_loop().create_future())


class Ros2ActionServer:
    """One action; `on_goal` gets the id and the payload of each goal, `on_cancel` the id of a goal to cancel.

    Every goal is accepted as long as there are fewer than `MAX_GOALS`. A goal being canceled remains active
    until `finish`. `empty_result` is the payload of a default result.
    """

    def __init__(
        self,
        action: str,
        types: ActionTypes,
        *,
        empty_result: bytes,
        on_goal: Callable[[bytes, bytes], None],
        on_cancel: Callable[[bytes], None],
    ) -> None:
        self.action = action
        self._types = types
        self._empty_result = empty_result
        self._on_goal = on_goal
        self._on_cancel = on_cancel
        self._goals: dict[bytes, _Goal] = {}
        self._stack = AsyncExitStack()
        self._graph: Graph | None = None
        self._feedback: Publisher | None = None
        self._status: Publisher | None = None

    async def open(self, graph: Graph) -> None:
        """Offer the action.

        Raises InvalidNameError, GraphError, UnknownTypeError; then nothing remains open.
        """
        self._graph = graph
        types = self._types
        try:
            self._feedback = await graph.advertise(f"{self.action}/{FEEDBACK_TOPIC}", types.feedback_message)
            self._stack.push_async_callback(self._feedback.close)
            self._status = await graph.advertise(f"{self.action}/{STATUS_TOPIC}", types.status, latch=True)
            self._stack.push_async_callback(self._status.close)
            for name, service_type, handler in (
                (CANCEL_SERVICE, types.cancel, self._handle_cancel),
                (GET_RESULT_SERVICE, types.get_result, self._handle_result),
                (SEND_GOAL_SERVICE, types.send_goal, self._handle_goal),
            ):
                server = await graph.advertise_service(f"{self.action}/{name}", service_type, handler)
                self._stack.push_async_callback(server.close)
        except BaseException:
            await self.close()
            raise
        self._publish_status()

    def feedback(self, goal_id: bytes, payload: bytes) -> None:
        """Publish feedback of a goal. Raises UnknownNameError for a goal that is not active."""
        self._running(goal_id)
        assert self._feedback is not None
        self._feedback.publish_raw([goal_id + payload])

    def finish(self, goal_id: bytes, status: GoalStatus, result: bytes | None = None) -> None:
        """End a goal, with a default result if `result` is None. Raises UnknownNameError like `feedback`."""
        goal = self._running(goal_id)
        goal.status = status
        goal.result.set_result(self._empty_result if result is None else result)
        self._publish_status()

    def is_running(self, goal_id: bytes) -> bool:
        """Return whether a goal is active."""
        goal = self._goals.get(goal_id)
        return goal is not None and goal.status not in _FINISHED

    async def close(self) -> None:
        """Abort the active goals, and stop offering the action. Idempotent."""
        for goal_id in list(self._goals):
            if self.is_running(goal_id):
                self.finish(goal_id, GoalStatus.ABORTED)
        # The callers get their answers before the services end.
        for _ in range(_TURNS_TO_ANSWER):
            await asyncio.sleep(0)
        await self._stack.aclose()

    def _running(self, goal_id: bytes) -> _Goal:
        if not self.is_running(goal_id):
            raise UnknownNameError(f"{self.action} has no active goal {goal_id.hex()}")
        return self._goals[goal_id]

    async def _handle_goal(self, request: bytes) -> bytes:
        assert self._graph is not None
        goal_id, now = request[:ID_BYTES], self._graph.now()
        stamp = (now.secs, now.nsecs)
        if len(self._goals) >= MAX_GOALS:
            self._forget_finished()
        is_accepted = goal_id not in self._goals and len(self._goals) < MAX_GOALS
        if is_accepted:
            self._goals[goal_id] = _Goal(stamp)
            self._publish_status()
            # Called after the answer, because feedback must not precede it.
            asyncio.get_running_loop().call_soon(self._on_goal, goal_id, request[ID_BYTES:])
        return bytes([is_accepted]) + STAMP.pack(*stamp)

    async def _handle_result(self, request: bytes) -> bytes:
        goal = self._goals.get(request[:ID_BYTES])
        if goal is None:
            return bytes([GoalStatus.UNKNOWN]) + self._empty_result
        result = await asyncio.shield(goal.result)
        return bytes([goal.status]) + result

    async def _handle_cancel(self, request: bytes) -> bytes:
        goal_id, stamp = request[:ID_BYTES], STAMP.unpack_from(request, ID_BYTES)
        chosen = [each for each in self._goals if self._is_chosen(each, goal_id, stamp)]
        code = CancelCode.NONE
        if goal_id in self._goals and not chosen:
            code = CancelCode.TERMINATED
        elif goal_id != _NO_ID and goal_id not in self._goals:
            code = CancelCode.UNKNOWN_GOAL
        answer = bytes([code]) + _COUNT.pack(len(chosen))
        for each in chosen:
            self._goals[each].status = GoalStatus.CANCELING
            answer += each + STAMP.pack(*self._goals[each].stamp)
            asyncio.get_running_loop().call_soon(self._on_cancel, each)
        self._publish_status()
        return answer

    def _is_chosen(self, each: bytes, goal_id: bytes, stamp: tuple[int, int]) -> bool:
        """Return whether a request cancels a goal: by id, by time, or because it cancels all goals."""
        if not self.is_running(each):
            return False
        is_for_all = goal_id == _NO_ID and stamp == _NO_STAMP
        return is_for_all or each == goal_id or (stamp != _NO_STAMP and self._goals[each].stamp <= stamp)

    def _forget_finished(self) -> None:
        """Forget the older half of the finished goals."""
        finished = [each for each in self._goals if not self.is_running(each)]
        for each in finished[: (len(finished) + 1) // 2]:
            del self._goals[each]

    def _publish_status(self) -> None:
        assert self._status is not None
        parts = [_COUNT.pack(len(self._goals))]
        parts += (
            goal_id + STAMP.pack(*goal.stamp) + bytes([goal.status]) for goal_id, goal in self._goals.items()
        )
        self._status.publish_raw([b"".join(parts)])
