# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import actionlib_msgs, geometry_msgs, std_msgs
from rostether.serde.values import Message

class MoveBaseAction(Message):
    action_goal: MoveBaseActionGoal
    action_result: MoveBaseActionResult
    action_feedback: MoveBaseActionFeedback
    def __init__(self, *, action_goal: MoveBaseActionGoal | Mapping[str, Any] = ..., action_result: MoveBaseActionResult | Mapping[str, Any] = ..., action_feedback: MoveBaseActionFeedback | Mapping[str, Any] = ...) -> None: ...

class MoveBaseActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: MoveBaseFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: MoveBaseFeedback | Mapping[str, Any] = ...) -> None: ...

class MoveBaseActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: MoveBaseGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: MoveBaseGoal | Mapping[str, Any] = ...) -> None: ...

class MoveBaseActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: MoveBaseResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: MoveBaseResult | Mapping[str, Any] = ...) -> None: ...

class MoveBaseFeedback(Message):
    base_position: geometry_msgs.PoseStamped
    def __init__(self, *, base_position: geometry_msgs.PoseStamped | Mapping[str, Any] = ...) -> None: ...

class MoveBaseGoal(Message):
    target_pose: geometry_msgs.PoseStamped
    def __init__(self, *, target_pose: geometry_msgs.PoseStamped | Mapping[str, Any] = ...) -> None: ...

class MoveBaseResult(Message):
    def __init__(self) -> None: ...

class RecoveryStatus(Message):
    pose_stamped: geometry_msgs.PoseStamped
    current_recovery_number: int
    total_number_of_recoveries: int
    recovery_behavior_name: str
    def __init__(self, *, pose_stamped: geometry_msgs.PoseStamped | Mapping[str, Any] = ..., current_recovery_number: int = ..., total_number_of_recoveries: int = ..., recovery_behavior_name: str = ...) -> None: ...
