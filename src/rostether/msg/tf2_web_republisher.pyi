# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import actionlib_msgs, geometry_msgs, std_msgs
from rostether.serde.values import Message

class TFArray(Message):
    transforms: list[geometry_msgs.TransformStamped]
    def __init__(self, *, transforms: Sequence[geometry_msgs.TransformStamped | Mapping[str, Any]] = ...) -> None: ...

class TFSubscriptionAction(Message):
    action_goal: TFSubscriptionActionGoal
    action_result: TFSubscriptionActionResult
    action_feedback: TFSubscriptionActionFeedback
    def __init__(self, *, action_goal: TFSubscriptionActionGoal | Mapping[str, Any] = ..., action_result: TFSubscriptionActionResult | Mapping[str, Any] = ..., action_feedback: TFSubscriptionActionFeedback | Mapping[str, Any] = ...) -> None: ...

class TFSubscriptionActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: TFSubscriptionFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: TFSubscriptionFeedback | Mapping[str, Any] = ...) -> None: ...

class TFSubscriptionActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: TFSubscriptionGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: TFSubscriptionGoal | Mapping[str, Any] = ...) -> None: ...

class TFSubscriptionActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: TFSubscriptionResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: TFSubscriptionResult | Mapping[str, Any] = ...) -> None: ...

class TFSubscriptionFeedback(Message):
    transforms: list[geometry_msgs.TransformStamped]
    def __init__(self, *, transforms: Sequence[geometry_msgs.TransformStamped | Mapping[str, Any]] = ...) -> None: ...

class TFSubscriptionGoal(Message):
    source_frames: list[str]
    target_frame: str
    angular_thres: float
    trans_thres: float
    rate: float
    def __init__(self, *, source_frames: Sequence[str] = ..., target_frame: str = ..., angular_thres: float = ..., trans_thres: float = ..., rate: float = ...) -> None: ...

class TFSubscriptionResult(Message):
    def __init__(self) -> None: ...
