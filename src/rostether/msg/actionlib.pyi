# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import actionlib_msgs, std_msgs
from rostether.serde.values import Message

class TestAction(Message):
    action_goal: TestActionGoal
    action_result: TestActionResult
    action_feedback: TestActionFeedback
    def __init__(self, *, action_goal: TestActionGoal | Mapping[str, Any] = ..., action_result: TestActionResult | Mapping[str, Any] = ..., action_feedback: TestActionFeedback | Mapping[str, Any] = ...) -> None: ...

class TestActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: TestFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: TestFeedback | Mapping[str, Any] = ...) -> None: ...

class TestActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: TestGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: TestGoal | Mapping[str, Any] = ...) -> None: ...

class TestActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: TestResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: TestResult | Mapping[str, Any] = ...) -> None: ...

class TestFeedback(Message):
    feedback: int
    def __init__(self, *, feedback: int = ...) -> None: ...

class TestGoal(Message):
    goal: int
    def __init__(self, *, goal: int = ...) -> None: ...

class TestRequestAction(Message):
    action_goal: TestRequestActionGoal
    action_result: TestRequestActionResult
    action_feedback: TestRequestActionFeedback
    def __init__(self, *, action_goal: TestRequestActionGoal | Mapping[str, Any] = ..., action_result: TestRequestActionResult | Mapping[str, Any] = ..., action_feedback: TestRequestActionFeedback | Mapping[str, Any] = ...) -> None: ...

class TestRequestActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: TestRequestFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: TestRequestFeedback | Mapping[str, Any] = ...) -> None: ...

class TestRequestActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: TestRequestGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: TestRequestGoal | Mapping[str, Any] = ...) -> None: ...

class TestRequestActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: TestRequestResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: TestRequestResult | Mapping[str, Any] = ...) -> None: ...

class TestRequestFeedback(Message):
    def __init__(self) -> None: ...

class TestRequestGoal(Message):
    TERMINATE_SUCCESS: int
    TERMINATE_ABORTED: int
    TERMINATE_REJECTED: int
    TERMINATE_LOSE: int
    TERMINATE_DROP: int
    TERMINATE_EXCEPTION: int
    terminate_status: int
    ignore_cancel: bool
    result_text: str
    the_result: int
    is_simple_client: bool
    delay_accept: rostime.Duration
    delay_terminate: rostime.Duration
    pause_status: rostime.Duration
    def __init__(self, *, terminate_status: int = ..., ignore_cancel: bool = ..., result_text: str = ..., the_result: int = ..., is_simple_client: bool = ..., delay_accept: rostime.Duration | float = ..., delay_terminate: rostime.Duration | float = ..., pause_status: rostime.Duration | float = ...) -> None: ...

class TestRequestResult(Message):
    the_result: int
    is_simple_server: bool
    def __init__(self, *, the_result: int = ..., is_simple_server: bool = ...) -> None: ...

class TestResult(Message):
    result: int
    def __init__(self, *, result: int = ...) -> None: ...

class TwoIntsAction(Message):
    action_goal: TwoIntsActionGoal
    action_result: TwoIntsActionResult
    action_feedback: TwoIntsActionFeedback
    def __init__(self, *, action_goal: TwoIntsActionGoal | Mapping[str, Any] = ..., action_result: TwoIntsActionResult | Mapping[str, Any] = ..., action_feedback: TwoIntsActionFeedback | Mapping[str, Any] = ...) -> None: ...

class TwoIntsActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: TwoIntsFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: TwoIntsFeedback | Mapping[str, Any] = ...) -> None: ...

class TwoIntsActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: TwoIntsGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: TwoIntsGoal | Mapping[str, Any] = ...) -> None: ...

class TwoIntsActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: TwoIntsResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: TwoIntsResult | Mapping[str, Any] = ...) -> None: ...

class TwoIntsFeedback(Message):
    def __init__(self) -> None: ...

class TwoIntsGoal(Message):
    a: int
    b: int
    def __init__(self, *, a: int = ..., b: int = ...) -> None: ...

class TwoIntsResult(Message):
    sum: int
    def __init__(self, *, sum: int = ...) -> None: ...
