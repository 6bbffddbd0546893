"""Sends goals to an action server."""

from __future__ import annotations

import asyncio
import contextlib
import uuid
from collections.abc import Callable, Sequence
from typing import Final

from rostether.errors import ServiceCallError
from rostether.graph.ports import Graph
from rostether.ros2.actions.types import (
    CANCEL_SERVICE,
    FEEDBACK_TOPIC,
    GET_RESULT_SERVICE,
    ID_BYTES,
    SEND_GOAL_SERVICE,
    STAMP,
    ActionTypes,
    GoalStatus,
)

# Feedback published before the topic is connected is lost; connecting takes less than this time.
CONNECTION_S: Final = 1.0


class GoalCall:
    """One goal; `action` is the action's full name."""

    def __init__(self, graph: Graph, action: str, types: ActionTypes) -> None:
        self.goal_id = uuid.uuid4().bytes
        self._graph = graph
        self._action = action
        self._types = types

    async def run(
        self, goal: bytes, on_feedback: Callable[[bytes], None] | None = None
    ) -> tuple[GoalStatus, bytes]:
        """Send the goal and return its final status and its result.

        Raises ServiceCallError if the server rejects it, and the errors of `Graph.call_service`.
        """
        if on_feedback is None:
            return await self._run(goal)

        def take(payloads: Sequence[bytes]) -> None:
            for payload in payloads:
                if payload[:ID_BYTES] == self.goal_id:
                    on_feedback(payload[ID_BYTES:])

        connected = asyncio.Event()
        subscriber = await self._graph.subscribe(
            f"{self._action}/{FEEDBACK_TOPIC}",
            self._types.feedback_message,
            take,
            on_connection=lambda _: connected.set(),
        )
        try:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(connected.wait(), CONNECTION_S)
            return await self._run(goal)
        finally:
            await subscriber.close()

    async def cancel(self) -> None:
        """Ask the server to cancel the goal; `run` returns its status. Raises as `Graph.call_service`."""
        request = self.goal_id + STAMP.pack(0, 0)
        await self._graph.call_service(f"{self._action}/{CANCEL_SERVICE}", self._types.cancel, request)

    async def _run(self, goal: bytes) -> tuple[GoalStatus, bytes]:
        service = f"{self._action}/{SEND_GOAL_SERVICE}"
        answer = await self._graph.call_service(service, self._types.send_goal, self.goal_id + goal)
        if not answer[0]:
            raise ServiceCallError(f"{self._action} rejected the goal")
        service = f"{self._action}/{GET_RESULT_SERVICE}"
        answer = await self._graph.call_service(service, self._types.get_result, self.goal_id)
        return GoalStatus(answer[0]), answer[1:]
