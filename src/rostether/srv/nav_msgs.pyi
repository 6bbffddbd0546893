# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import geometry_msgs, nav_msgs
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class GetMapRequest(Message):
    def __init__(self) -> None: ...

class GetMapResponse(Message):
    map: nav_msgs.OccupancyGrid
    def __init__(self, *, map: nav_msgs.OccupancyGrid | Mapping[str, Any] = ...) -> None: ...

class GetMap(Service[GetMapRequest, GetMapResponse]): ...

class GetPlanRequest(Message):
    start: geometry_msgs.PoseStamped
    goal: geometry_msgs.PoseStamped
    tolerance: float
    def __init__(self, *, start: geometry_msgs.PoseStamped | Mapping[str, Any] = ..., goal: geometry_msgs.PoseStamped | Mapping[str, Any] = ..., tolerance: float = ...) -> None: ...

class GetPlanResponse(Message):
    plan: nav_msgs.Path
    def __init__(self, *, plan: nav_msgs.Path | Mapping[str, Any] = ...) -> None: ...

class GetPlan(Service[GetPlanRequest, GetPlanResponse]): ...

class LoadMapRequest(Message):
    map_url: str
    def __init__(self, *, map_url: str = ...) -> None: ...

class LoadMapResponse(Message):
    RESULT_SUCCESS: int
    RESULT_MAP_DOES_NOT_EXIST: int
    RESULT_INVALID_MAP_DATA: int
    RESULT_INVALID_MAP_METADATA: int
    RESULT_UNDEFINED_FAILURE: int
    map: nav_msgs.OccupancyGrid
    result: int
    def __init__(self, *, map: nav_msgs.OccupancyGrid | Mapping[str, Any] = ..., result: int = ...) -> None: ...

class LoadMap(Service[LoadMapRequest, LoadMapResponse]): ...

class SetMapRequest(Message):
    map: nav_msgs.OccupancyGrid
    initial_pose: geometry_msgs.PoseWithCovarianceStamped
    def __init__(self, *, map: nav_msgs.OccupancyGrid | Mapping[str, Any] = ..., initial_pose: geometry_msgs.PoseWithCovarianceStamped | Mapping[str, Any] = ...) -> None: ...

class SetMapResponse(Message):
    success: bool
    def __init__(self, *, success: bool = ...) -> None: ...

class SetMap(Service[SetMapRequest, SetMapResponse]): ...
