# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import sensor_msgs, std_msgs
from rostether.serde.values import Message

class Detections(Message):
    header: std_msgs.Header
    classifier: str
    regions: list[sensor_msgs.RegionOfInterest]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., classifier: str = ..., regions: Sequence[sensor_msgs.RegionOfInterest | Mapping[str, Any]] = ...) -> None: ...

class Fleet(Message):
    robots: list[RobotState]
    def __init__(self, *, robots: Sequence[RobotState | Mapping[str, Any]] = ...) -> None: ...

class RobotState(Message):
    id: int
    address: str
    state: str
    commanded_by: str
    loss: float
    signal_dbm: int
    uses_unicast: bool
    answered: rostime.Time
    def __init__(self, *, id: int = ..., address: str = ..., state: str = ..., commanded_by: str = ..., loss: float = ..., signal_dbm: int = ..., uses_unicast: bool = ..., answered: rostime.Time | float | Literal["now"] = ...) -> None: ...

class Sensor(Message):
    id: str
    name: str
    platform_name: str
    sensor_type: str
    topic: str
    message_type: str
    unit: str
    frame_id: str
    rate_hz: float
    lease_s: float
    state: str
    state_text: str
    state_since: rostime.Time
    def __init__(self, *, id: str = ..., name: str = ..., platform_name: str = ..., sensor_type: str = ..., topic: str = ..., message_type: str = ..., unit: str = ..., frame_id: str = ..., rate_hz: float = ..., lease_s: float = ..., state: str = ..., state_text: str = ..., state_since: rostime.Time | float | Literal["now"] = ...) -> None: ...

class Sensors(Message):
    sensors: list[Sensor]
    def __init__(self, *, sensors: Sequence[Sensor | Mapping[str, Any]] = ...) -> None: ...
