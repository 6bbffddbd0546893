# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import std_msgs
from rostether.serde.values import Message

class SensorState(Message):
    BUMPER_FORWARD: int
    BUMPER_BACKWARD: int
    CLIFF: int
    SONAR: int
    ILLUMINATION: int
    BUTTON0: int
    BUTTON1: int
    ERROR_LEFT_MOTOR: int
    ERROR_RIGHT_MOTOR: int
    TORQUE_ON: int
    TORQUE_OFF: int
    header: std_msgs.Header
    bumper: int
    cliff: float
    sonar: float
    illumination: float
    led: int
    button: int
    torque: bool
    left_encoder: int
    right_encoder: int
    battery: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., bumper: int = ..., cliff: float = ..., sonar: float = ..., illumination: float = ..., led: int = ..., button: int = ..., torque: bool = ..., left_encoder: int = ..., right_encoder: int = ..., battery: float = ...) -> None: ...

class Sound(Message):
    OFF: int
    ON: int
    LOW_BATTERY: int
    ERROR: int
    BUTTON1: int
    BUTTON2: int
    value: int
    def __init__(self, *, value: int = ...) -> None: ...

class VersionInfo(Message):
    hardware: str
    firmware: str
    software: str
    def __init__(self, *, hardware: str = ..., firmware: str = ..., software: str = ...) -> None: ...
