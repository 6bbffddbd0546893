"""The types and names of an action on a ROS 2 graph; `msgdef.ros2.action_parts` has the table.

A goal's id has 16 bytes, which precede the payloads of goals and feedback. Payloads have the form of the
graph port.
"""

from __future__ import annotations

import asyncio
import struct
import uuid
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Final

import msgspec

from rostether.errors import ServiceCallError
from rostether.graph.ports import Graph
from rostether.mechanisms.block_end import closed_at_end
from rostether.mechanisms.tasks import occurs_within
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.ros2.action_parts import FEEDBACK_MESSAGE, GET_RESULT, SEND_GOAL
from rostether.ros2.types.native_registry import NativeRegistry, short_name

SEND_GOAL_SERVICE: Final = "_action/send_goal"
GET_RESULT_SERVICE: Final = "_action/get_result"
CANCEL_SERVICE: Final = "_action/cancel_goal"
FEEDBACK_TOPIC: Final = "_action/feedback"
STATUS_TOPIC: Final = "_action/status"

# The messages of a definition, in order.
PARTS: Final = ("Goal", "Result", "Feedback")

ID_BYTES: Final = 16
STAMP: Final = struct.Struct("<iI")

# Feedback published before the topic is connected is lost; connecting takes less than this time.
CONNECTION_S: Final = 1.0


class GoalStatus(IntEnum):
    """The status of a goal, with the values of action_msgs/GoalStatus."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


class CancelCode(IntEnum):
    """The answer to a cancel request, with the values of action_msgs/CancelGoal."""

    NONE = 0
    REJECTED = 1
    UNKNOWN_GOAL = 2
    TERMINATED = 3


class ActionTypes(msgspec.Struct, frozen=True):
    """One action type; `goal`, `result` and `feedback` are names of messages in the registry."""

    goal: str
    result: str
    feedback: str
    send_goal: ServiceType
    get_result: ServiceType
    cancel: ServiceType
    feedback_message: MessageType
    status: MessageType

    @classmethod
    def find(cls, registry: NativeRegistry, name: str) -> ActionTypes:
        """Return the types of `package/Name` or `package/action/Name`.

        Raises UnknownTypeError, DefinitionError.
        """
        package, _, rest = name.partition("/")
        full_name = f"{package}/action/{rest.removeprefix('action/')}"
        goal, result, feedback = (f"{full_name}_{part}" for part in PARTS)
        if not registry.definitions.has(goal):
            registry.definitions.action(full_name)
        return cls(
            short_name(goal),
            short_name(result),
            short_name(feedback),
            send_goal=registry.service_type(full_name + SEND_GOAL),
            get_result=registry.service_type(full_name + GET_RESULT),
            cancel=registry.service_type("action_msgs/srv/CancelGoal"),
            feedback_message=registry.message_type(full_name + FEEDBACK_MESSAGE),
            status=registry.message_type("action_msgs/msg/GoalStatusArray"),
        )


class GoalCall:
    """A client's call of one goal; `action` is the action's full name."""

    def __init__(self, graph: Graph, action: str, types: ActionTypes) -> None:
        self.goal_id = uuid.uuid4().bytes
        self._graph = graph
        self._action = action
        self._types = types

    async def run(
        self,
        goal: bytes,
        on_feedback: Callable[[bytes], None] | None = None,
        on_accepted: Callable[[], None] | None = None,
    ) -> tuple[GoalStatus, bytes]:
        """Send the goal and return its final status and its result.

        `on_accepted` is called when the server has accepted the goal, `on_feedback` with each feedback.
        Raises ServiceCallError if the server rejects the goal, and the errors of `Graph.call_service`.
        """
        if on_feedback is None:
            return await self._run(goal, on_accepted)

        def handle_feedback(payloads: Sequence[bytes]) -> None:
            for payload in payloads:
                if payload[:ID_BYTES] == self.goal_id:
                    on_feedback(payload[ID_BYTES:])

        connected = asyncio.Event()
        subscriber = await self._graph.subscribe(
            f"{self._action}/{FEEDBACK_TOPIC}",
            self._types.feedback_message,
            handle_feedback,
            on_connection=lambda _: connected.set(),
        )
        async with closed_at_end(subscriber):
            await occurs_within(connected, CONNECTION_S)
            return await self._run(goal, on_accepted)

    async def cancel(self) -> None:
        """Ask the server to cancel the goal; `run` returns its status.

        Raises the same errors as `Graph.call_service`.
        """
        request = self.goal_id + STAMP.pack(0, 0)
        await self._graph.call_service(f"{self._action}/{CANCEL_SERVICE}", self._types.cancel, request)

    async def _run(self, goal: bytes, on_accepted: Callable[[], None] | None) -> tuple[GoalStatus, bytes]:
        service = f"{self._action}/{SEND_GOAL_SERVICE}"
        answer = await self._graph.call_service(service, self._types.send_goal, self.goal_id + goal)
        if not answer[0]:
            raise ServiceCallError(f"{self._action} rejected the goal")
        if on_accepted is not None:
            on_accepted()
        service = f"{self._action}/{GET_RESULT_SERVICE}"
        answer = await self._graph.call_service(service, self._types.get_result, self.goal_id)
        return GoalStatus(answer[0]), answer[1:]
