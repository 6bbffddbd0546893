"""Offers a board's action, which consists of topics as in ROS 1, as a ROS 2 action.

    ROS 2 action client  --  ActionServer  --  goal, cancel, feedback, result, status  --  the board

A goal's id of 16 bytes is a string of 32 digits for the board. The board's messages have the form of ROS 1;
goal, result and feedback are converted to the form of ROS 2 and back.
"""

from __future__ import annotations

import asyncio
import struct
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from rostether.errors import DefinitionError
from rostether.graph.ports import Graph, OnMessages
from rostether.msgdef.ros2.action_parts import action_parts
from rostether.msgdef.ros2.from_ros1 import derive
from rostether.msgdef.ros2.spec import Ros2Action, Ros2Message, Ros2Type
from rostether.ros2.actions.server import ActionServer
from rostether.ros2.actions.types import PARTS, ActionTypes, GoalStatus
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.cdr.converter import CdrConverter
from rostether.serde.store import TypeStore

# A board on a slow line receives a goal within this time; after that, its status must list the goal.
LOST_AFTER_S: Final = 5.0

# The final states of actionlib_msgs/GoalStatus, and their equivalents in ROS 2.
_PREEMPTED: Final = 2
_FINAL: Final = {
    _PREEMPTED: GoalStatus.CANCELED,
    3: GoalStatus.SUCCEEDED,
    4: GoalStatus.ABORTED,
    5: GoalStatus.ABORTED,  # rejected
    8: GoalStatus.CANCELED,  # recalled
}
_COUNT = struct.Struct("<I")
# The fields of std_msgs/Header before the frame id, and of actionlib_msgs/GoalID before the id.
_HEADER = struct.Struct("<III")
_STAMP = struct.Struct("<II")


class BoardAction:
    """One action, `action_type` as `package/Name`; the callbacks receive messages for the board.

    `types` are the types of the boards' graph.
    """

    def __init__(self, action: str, action_type: str, types: Ros2Types) -> None:
        self.action = action
        self.action_type = action_type
        self.on_goals: OnMessages | None = None
        self.on_cancels: OnMessages | None = None
        self._types = types
        self._clock = asyncio.get_running_loop().time
        self._graph: Graph | None = None
        self._server: ActionServer | None = None
        # The active goals by their id strings, and their send times.
        self._sent_s: dict[str, float] = {}
        self._canceled: set[str] = set()

    async def open(self, graph: Graph, types: NativeTypes, registry: NativeRegistry) -> None:
        """Offer the action on a node with native ROS 2 types. Raises GraphError, DefinitionError."""
        found = self._find_types(registry)
        self._graph = graph
        self._goal = self._pair(types, registry, found.goal, "Goal")
        self._result = self._pair(types, registry, found.result, "Result")
        self._feedback = self._pair(types, registry, found.feedback, "Feedback")
        server = ActionServer(
            self.action,
            found,
            empty_result=TypeStore(registry).codec(found.result).encode({}),
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

    def take_feedback(self, payloads: Sequence[bytes]) -> None:
        """Publish the feedback of goals in progress."""
        if self._server is None:
            return
        for payload in payloads:
            text, _, content = _read_status(payload, _after_header(payload))
            if text in self._sent_s:
                self._server.feedback(bytes.fromhex(text), _convert(self._feedback, payload[content:]))

    def take_results(self, payloads: Sequence[bytes]) -> None:
        """End goals with their results."""
        for payload in payloads:
            text, status, content = _read_status(payload, _after_header(payload))
            if text in self._sent_s:
                # Preempted by another goal, not by its own client.
                is_replaced = status == _PREEMPTED and text not in self._canceled
                final = GoalStatus.ABORTED if is_replaced else _FINAL.get(status, GoalStatus.ABORTED)
                self._finish(text, final, _convert(self._result, payload[content:]))

    def take_statuses(self, payloads: Sequence[bytes]) -> None:
        """Abort the goals that the board no longer knows, because it was reset."""
        payload = payloads[-1]
        position = _after_header(payload)
        (count,) = _COUNT.unpack_from(payload, position)
        position += _COUNT.size
        listed = set()
        for _ in range(count):
            text, _, position = _read_status(payload, position)
            listed.add(text)
        old = [text for text, sent_s in self._sent_s.items() if self._clock() - sent_s > LOST_AFTER_S]
        for text in old:
            if text not in listed:
                self._finish(text, GoalStatus.ABORTED, None)

    def _find_types(self, registry: NativeRegistry) -> ActionTypes:
        """Return the action's types; if only ROS 1 has a definition, ROS 2 uses it too."""
        package, _, name = self.action_type.partition("/")
        ros1, definitions = self._types.registry, registry.definitions
        parts = [
            replace(
                derive(ros1.message(f"{self.action_type}{part}"), ros1), kind="action", name=f"{name}_{part}"
            )
            for part in PARTS
        ]
        definitions.add(action_parts(Ros2Action(package, name, *parts)).messages())
        found = ActionTypes.find(registry, self.action_type)
        for part in parts:
            if _layout(part) != _layout(definitions.message(part.full_name)):
                raise DefinitionError(
                    f"{part.full_name} of ROS 2 and of the board differ; use one definition for both"
                )
        return found

    def _pair(
        self, types: NativeTypes, registry: NativeRegistry, native: str, part: str
    ) -> tuple[CdrConverter, CdrConverter]:
        """Return the converters of a part: for the board's form, and for the native form of ROS 2."""
        ours = self._types.message(self._types.registry.message_type(f"{self.action_type}{part}"))
        return ours.converter, types.message(registry.message_type(native)).converter

    def _send_goal(self, goal_id: bytes, payload: bytes) -> None:
        assert self._graph is not None
        ours, native = self._goal
        text, now = goal_id.hex(), self._graph.now()
        self._sent_s[text] = self._clock()
        if self.on_goals is not None:
            header = _HEADER.pack(0, now.secs, now.nsecs) + _COUNT.pack(0)
            goal = ours.from_cdr(native.to_cdr(payload))
            self.on_goals([header + _STAMP.pack(now.secs, now.nsecs) + _text(text) + goal])

    def _send_cancel(self, goal_id: bytes) -> None:
        self._canceled.add(goal_id.hex())
        if self.on_cancels is not None:
            self.on_cancels([_STAMP.pack(0, 0) + _text(goal_id.hex())])

    def _finish(self, text: str, status: GoalStatus, result: bytes | None) -> None:
        del self._sent_s[text]
        self._canceled.discard(text)
        if self._server is not None:
            self._server.finish(bytes.fromhex(text), status, result)


def _layout(message: Ros2Message) -> list[tuple[str, Ros2Type]]:
    return [(each.name, each.type) for each in message.fields]


def _convert(pair: tuple[CdrConverter, CdrConverter], payload: bytes) -> bytes:
    """Convert a part of a board's message to the native form of ROS 2."""
    ours, native = pair
    return native.from_cdr(ours.to_cdr(payload))


def _text(text: str) -> bytes:
    return _COUNT.pack(len(text)) + text.encode()


def _after_header(payload: bytes) -> int:
    return _read_text(payload, _HEADER.size)[1]


def _read_status(payload: bytes, position: int) -> tuple[str, int, int]:
    """Read a GoalStatus: the goal's id, the status, and the position after it."""
    text, position = _read_text(payload, position + _STAMP.size)
    status = payload[position]
    return text, status, _read_text(payload, position + 1)[1]


def _read_text(payload: bytes, position: int) -> tuple[str, int]:
    (length,) = _COUNT.unpack_from(payload, position)
    start = position + _COUNT.size
    return payload[start : start + length].decode("utf-8", "replace"), start + length
