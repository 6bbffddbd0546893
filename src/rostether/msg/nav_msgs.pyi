# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import actionlib_msgs, geometry_msgs, std_msgs
from rostether.serde.values import Message

class GetMapAction(Message):
    action_goal: GetMapActionGoal
    action_result: GetMapActionResult
    action_feedback: GetMapActionFeedback
    def __init__(self, *, action_goal: GetMapActionGoal | Mapping[str, Any] = ..., action_result: GetMapActionResult | Mapping[str, Any] = ..., action_feedback: GetMapActionFeedback | Mapping[str, Any] = ...) -> None: ...

class GetMapActionFeedback(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    feedback: GetMapFeedback
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., feedback: GetMapFeedback | Mapping[str, Any] = ...) -> None: ...

class GetMapActionGoal(Message):
    header: std_msgs.Header
    goal_id: actionlib_msgs.GoalID
    goal: GetMapGoal
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., goal_id: actionlib_msgs.GoalID | Mapping[str, Any] = ..., goal: GetMapGoal | Mapping[str, Any] = ...) -> None: ...

class GetMapActionResult(Message):
    header: std_msgs.Header
    status: actionlib_msgs.GoalStatus
    result: GetMapResult
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: actionlib_msgs.GoalStatus | Mapping[str, Any] = ..., result: GetMapResult | Mapping[str, Any] = ...) -> None: ...

class GetMapFeedback(Message):
    def __init__(self) -> None: ...

class GetMapGoal(Message):
    def __init__(self) -> None: ...

class GetMapResult(Message):
    map: OccupancyGrid
    def __init__(self, *, map: OccupancyGrid | Mapping[str, Any] = ...) -> None: ...

class GridCells(Message):
    header: std_msgs.Header
    cell_width: float
    cell_height: float
    cells: list[geometry_msgs.Point]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., cell_width: float = ..., cell_height: float = ..., cells: Sequence[geometry_msgs.Point | Mapping[str, Any]] = ...) -> None: ...

class MapMetaData(Message):
    map_load_time: rostime.Time
    resolution: float
    width: int
    height: int
    origin: geometry_msgs.Pose
    def __init__(self, *, map_load_time: rostime.Time | float | Literal["now"] = ..., resolution: float = ..., width: int = ..., height: int = ..., origin: geometry_msgs.Pose | Mapping[str, Any] = ...) -> None: ...

class OccupancyGrid(Message):
    header: std_msgs.Header
    info: MapMetaData
    data: list[int]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., info: MapMetaData | Mapping[str, Any] = ..., data: Sequence[int] = ...) -> None: ...

class Odometry(Message):
    header: std_msgs.Header
    child_frame_id: str
    pose: geometry_msgs.PoseWithCovariance
    twist: geometry_msgs.TwistWithCovariance
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., child_frame_id: str = ..., pose: geometry_msgs.PoseWithCovariance | Mapping[str, Any] = ..., twist: geometry_msgs.TwistWithCovariance | Mapping[str, Any] = ...) -> None: ...

class Path(Message):
    header: std_msgs.Header
    poses: list[geometry_msgs.PoseStamped]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., poses: Sequence[geometry_msgs.PoseStamped | Mapping[str, Any]] = ...) -> None: ...
