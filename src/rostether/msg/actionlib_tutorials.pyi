# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import actionlib_msgs, std_msgs
from rostether.serde.values import Message

class AveragingAction(Message):
    action_goal: AveragingActionGoal
    action_result: AveragingActionResult
    action_feedback: AveragingActionFeedback
    def __init__(self, *, action_goal: AveragingActionGoal | Mapping[str, Any] = ..., action_result: AveragingActionResult | Mapping[str, Any] = ..., action_feedback: AveragingActionFeedback | Mapping[str, Any] = ...) -> None: ...

class AveragingActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: AveragingFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: AveragingFeedback | Mapping[str, Any] = ...) -> None: ...

class AveragingActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: AveragingGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: AveragingGoal | Mapping[str, Any] = ...) -> None: ...

class AveragingActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: AveragingResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: AveragingResult | Mapping[str, Any] = ...) -> None: ...

class AveragingFeedback(Message):
    sample: int
    data: float
    mean: float
    std_dev: float
    def __init__(self, *, sample: int = ..., data: float = ..., mean: float = ..., std_dev: float = ...) -> None: ...

class AveragingGoal(Message):
    samples: int
    def __init__(self, *, samples: int = ...) -> None: ...

class AveragingResult(Message):
    mean: float
    std_dev: float
    def __init__(self, *, mean: float = ..., std_dev: float = ...) -> None: ...

class FibonacciAction(Message):
    action_goal: FibonacciActionGoal
    action_result: FibonacciActionResult
    action_feedback: FibonacciActionFeedback
    def __init__(self, *, action_goal: FibonacciActionGoal | Mapping[str, Any] = ..., action_result: FibonacciActionResult | Mapping[str, Any] = ..., action_feedback: FibonacciActionFeedback | Mapping[str, Any] = ...) -> None: ...

class FibonacciActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: FibonacciFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: FibonacciFeedback | Mapping[str, Any] = ...) -> None: ...

class FibonacciActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: FibonacciGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: FibonacciGoal | Mapping[str, Any] = ...) -> None: ...

class FibonacciActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: FibonacciResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: FibonacciResult | Mapping[str, Any] = ...) -> None: ...

class FibonacciFeedback(Message):
    sequence: list[int]
    def __init__(self, *, sequence: Sequence[int] = ...) -> None: ...

class FibonacciGoal(Message):
    order: int
    def __init__(self, *, order: int = ...) -> None: ...

class FibonacciResult(Message):
    sequence: list[int]
    def __init__(self, *, sequence: Sequence[int] = ...) -> None: ...
