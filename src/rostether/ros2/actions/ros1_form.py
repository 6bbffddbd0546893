"""An action in the form of ROS 1, five topics with messages of actionlib_msgs, and its conversion to ROS 2.

goal      [NameActionGoal]      Header, GoalID, goal             to the server
cancel    [GoalID]              stamp, id                        to the server
feedback  [NameActionFeedback]  Header, GoalStatus, feedback     to the clients
result    [NameActionResult]    Header, GoalStatus, result       to the clients
status    [GoalStatusArray]     Header, list of GoalStatus       to the clients, several times a second
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Final

import msgspec
from msgspec.structs import replace

from rostether.errors import DefinitionError, SerializationError
from rostether.mechanisms.text import counted
from rostether.msgdef.ros2.action_parts import action_parts
from rostether.msgdef.ros2.from_ros1 import derive
from rostether.msgdef.ros2.spec import Ros2Action, Ros2Message, Ros2Type
from rostether.ros2.actions.types import PARTS, ActionTypes
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types
from rostether.rostime import Time
from rostether.serde.cdr.converter import CdrConverter
from rostether.serde.store import TypeStore

# The topics of an action, and their types: the ending after the package and the name of the action, or the
# whole name.
GOAL: Final = ("/goal", "ActionGoal")
CANCEL: Final = ("/cancel", "actionlib_msgs/GoalID")
FEEDBACK: Final = ("/feedback", "ActionFeedback")
RESULT: Final = ("/result", "ActionResult")
STATUS: Final = ("/status", "actionlib_msgs/GoalStatusArray")

_COUNT = struct.Struct("<I")
# The fields of std_msgs/Header before the frame id, and of actionlib_msgs/GoalID before the id.
_HEADER = struct.Struct("<III")
_STAMP = struct.Struct("<II")


class Ros1Status(IntEnum):
    """The status of a goal, with the values of actionlib_msgs/GoalStatus."""

    PENDING = 0
    ACTIVE = 1
    PREEMPTED = 2
    SUCCEEDED = 3
    ABORTED = 4
    REJECTED = 5
    PREEMPTING = 6
    RECALLED = 8


class GoalId(msgspec.Struct, frozen=True):
    """The id of a ROS 1 goal.

    In a goal, a zero stamp means now, and an empty text a new id. In a cancel request, both together mean all
    goals; a stamp means all goals up to this time.
    """

    stamp: tuple[int, int]
    text: str

    @classmethod
    def read(cls, payload: bytes, position: int = 0) -> tuple[GoalId, int]:
        """Read an id; return it and the position after it. Raises SerializationError."""
        text, end = _read_text(payload, position + _STAMP.size)
        return cls(_STAMP.unpack_from(payload, position), text), end

    def write(self) -> bytes:
        """Return the serialized id."""
        return _STAMP.pack(*self.stamp) + write_text(self.text)

    def status(self, status: int, text: str) -> bytes:
        """Return a serialized GoalStatus of this goal."""
        return self.write() + bytes([status]) + write_text(text)


def type_of_part(part: tuple[str, str], action_type: str) -> str:
    """Return the type of a topic of an action of type `package/Name`."""
    return part[1] if "/" in part[1] else action_type + part[1]


class ActionForms:
    """Converts an action, `action_type` as `package/Name`, between ROS 1 and the native form of ROS 2.

    `ros1` has the types of ROS 1, and `types` the native ones. Raises DefinitionError.
    """

    def __init__(self, action_type: str, ros1: Ros2Types, types: NativeTypes) -> None:
        registry = types.registry
        self.types = _find_types(action_type, ros1, registry)
        codec = TypeStore(registry).codec
        self.empty_result = codec(self.types.result).encode({})
        self._pairs: dict[str, tuple[CdrConverter, CdrConverter]] = {}
        for part, native in zip(
            PARTS, (self.types.goal, self.types.result, self.types.feedback), strict=True
        ):
            form = ros1.message(ros1.registry.message_type(f"{action_type}{part}"))
            native_form = types.message(registry.message_type(native))
            self._pairs[part] = (form.converter, native_form.converter)

    def to_ros1(self, part: str, payload: bytes) -> bytes:
        """Convert a `Goal`, `Result` or `Feedback` to ROS 1. Raises SerializationError."""
        ros1, native = self._pairs[part]
        return ros1.from_cdr(native.to_cdr(payload))

    def to_native(self, part: str, payload: bytes) -> bytes:
        """Convert a `Goal`, `Result` or `Feedback` to ROS 2. Raises SerializationError."""
        ros1, native = self._pairs[part]
        return native.from_cdr(ros1.to_cdr(payload))


def write_header(now: Time) -> bytes:
    """Return a serialized std_msgs/Header without a frame."""
    return _HEADER.pack(0, now.secs, now.nsecs) + _COUNT.pack(0)


def after_header(payload: bytes) -> int:
    """Return the position after a std_msgs/Header. Raises SerializationError."""
    return _read_text(payload, _HEADER.size)[1]


def read_status(payload: bytes, position: int) -> tuple[str, int, int]:
    """Read a GoalStatus: the goal's id, the status, and the position after it.

    Raises SerializationError.
    """
    goal_id, position = GoalId.read(payload, position)
    _, end = _read_text(payload, position + 1)
    return goal_id.text, payload[position], end


def read_statuses(payload: bytes) -> set[str]:
    """Return the ids of the goals in a GoalStatusArray. Raises SerializationError."""
    position = after_header(payload)
    count = _read_count(payload, position)
    position += _COUNT.size
    listed = set()
    for _ in range(count):
        text, _, position = read_status(payload, position)
        listed.add(text)
    return listed


def write_statuses(now: Time, statuses: list[bytes]) -> bytes:
    """Return a serialized GoalStatusArray."""
    return write_header(now) + _COUNT.pack(len(statuses)) + b"".join(statuses)


def write_text(text: str) -> bytes:
    """Return a serialized string of ROS 1."""
    encoded = text.encode()
    return _COUNT.pack(len(encoded)) + encoded


def _find_types(action_type: str, ros1_types: Ros2Types, registry: NativeRegistry) -> ActionTypes:
    """Return the action's types; if only ROS 1 has a definition, ROS 2 uses it too."""
    package, _, name = action_type.partition("/")
    ros1, definitions = ros1_types.registry, registry.definitions
    parts = [
        replace(derive(ros1.message(f"{action_type}{part}"), ros1), kind="action", name=f"{name}_{part}")
        for part in PARTS
    ]
    definitions.add(action_parts(Ros2Action(package, name, *parts)).messages())
    found = ActionTypes.find(registry, action_type)
    for part in parts:
        if _layout(part) != _layout(definitions.message(part.full_name)):
            raise DefinitionError(
                f"{part.full_name} of ROS 2 and of ROS 1 differ; use one definition for both"
            )
    return found


def _layout(message: Ros2Message) -> list[tuple[str, Ros2Type]]:
    return [(each.name, each.type) for each in message.fields]


def _read_text(payload: bytes, position: int) -> tuple[str, int]:
    length = _read_count(payload, position)
    start = position + _COUNT.size
    return payload[start : start + length].decode("utf-8", "replace"), start + length


def _read_count(payload: bytes, position: int) -> int:
    if len(payload) < position + _COUNT.size:
        size = counted(len(payload), "byte")
        raise SerializationError(f"the message ends early, after {size}; make both ends use one definition")
    count: int = _COUNT.unpack_from(payload, position)[0]
    return count
