# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import std_msgs
from rostether.serde.values import Message

class GoalID(Message):
    stamp: rostime.Time
    id: str
    def __init__(self, *, stamp: rostime.Time | float | Literal["now"] = ..., id: str = ...) -> None: ...

class GoalStatus(Message):
    PENDING: int
    ACTIVE: int
    PREEMPTED: int
    SUCCEEDED: int
    ABORTED: int
    REJECTED: int
    PREEMPTING: int
    RECALLING: int
    RECALLED: int
    LOST: int
    goal_id: GoalID
    status: int
    text: str
    def __init__(self, *, goal_id: GoalID | Mapping[str, Any] = ..., status: int = ..., text: str = ...) -> None: ...

class GoalStatusArray(Message):
    header: std_msgs.Header
    status_list: list[GoalStatus]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status_list: Sequence[GoalStatus | Mapping[str, Any]] = ...) -> None: ...
