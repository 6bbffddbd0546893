# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import actionlib_msgs, geometry_msgs, std_msgs
from rostether.serde.values import Message

class LookupTransformAction(Message):
    action_goal: LookupTransformActionGoal
    action_result: LookupTransformActionResult
    action_feedback: LookupTransformActionFeedback
    def __init__(self, *, action_goal: LookupTransformActionGoal | Mapping[str, Any] = ..., action_result: LookupTransformActionResult | Mapping[str, Any] = ..., action_feedback: LookupTransformActionFeedback | Mapping[str, Any] = ...) -> None: ...

class LookupTransformActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: LookupTransformFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: LookupTransformFeedback | Mapping[str, Any] = ...) -> None: ...

class LookupTransformActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: LookupTransformGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: LookupTransformGoal | Mapping[str, Any] = ...) -> None: ...

class LookupTransformActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: LookupTransformResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: LookupTransformResult | Mapping[str, Any] = ...) -> None: ...

class LookupTransformFeedback(Message):
    def __init__(self) -> None: ...

class LookupTransformGoal(Message):
    target_frame: str
    source_frame: str
    source_time: rostime.Time
    timeout: rostime.Duration
    target_time: rostime.Time
    fixed_frame: str
    advanced: bool
    def __init__(self, *, target_frame: str = ..., source_frame: str = ..., source_time: rostime.Time | float | Literal["now"] = ..., timeout: rostime.Duration | float = ..., target_time: rostime.Time | float | Literal["now"] = ..., fixed_frame: str = ..., advanced: bool = ...) -> None: ...

class LookupTransformResult(Message):
    transform: geometry_msgs.TransformStamped
    error: TF2Error
    def __init__(self, *, transform: geometry_msgs.TransformStamped | Mapping[str, Any] = ..., error: TF2Error | Mapping[str, Any] = ...) -> None: ...

class TF2Error(Message):
    NO_ERROR: int
    LOOKUP_ERROR: int
    CONNECTIVITY_ERROR: int
    EXTRAPOLATION_ERROR: int
    INVALID_ARGUMENT_ERROR: int
    TIMEOUT_ERROR: int
    TRANSFORM_ERROR: int
    error: int
    error_string: str
    def __init__(self, *, error: int = ..., error_string: str = ...) -> None: ...

class TFMessage(Message):
    transforms: list[geometry_msgs.TransformStamped]
    def __init__(self, *, transforms: Sequence[geometry_msgs.TransformStamped | Mapping[str, Any]] = ...) -> None: ...
