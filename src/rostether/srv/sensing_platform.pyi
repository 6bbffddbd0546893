# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import sensing_platform
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class RegisterSensorRequest(Message):
    id: str
    instance: str
    name: str
    platform_name: str
    sensor_type: str
    message_type: str
    unit: str
    frame_id: str
    rate_hz: float
    lease_s: float
    state: str
    state_text: str
    def __init__(self, *, id: str = ..., instance: str = ..., name: str = ..., platform_name: str = ..., sensor_type: str = ..., message_type: str = ..., unit: str = ..., frame_id: str = ..., rate_hz: float = ..., lease_s: float = ..., state: str = ..., state_text: str = ...) -> None: ...

class RegisterSensorResponse(Message):
    topic: str
    name: str
    refusal: str
    def __init__(self, *, topic: str = ..., name: str = ..., refusal: str = ...) -> None: ...

class RegisterSensor(Service[RegisterSensorRequest, RegisterSensorResponse]): ...

class RenameSensorRequest(Message):
    id: str
    name: str
    def __init__(self, *, id: str = ..., name: str = ...) -> None: ...

class RenameSensorResponse(Message):
    sensor: sensing_platform.Sensor
    def __init__(self, *, sensor: sensing_platform.Sensor | Mapping[str, Any] = ...) -> None: ...

class RenameSensor(Service[RenameSensorRequest, RenameSensorResponse]): ...

class StopRobotsRequest(Message):
    robot: int
    def __init__(self, *, robot: int = ...) -> None: ...

class StopRobotsResponse(Message):
    confirmed: list[int]
    def __init__(self, *, confirmed: Sequence[int] = ...) -> None: ...

class StopRobots(Service[StopRobotsRequest, StopRobotsResponse]): ...
