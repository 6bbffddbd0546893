# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import sensor_msgs
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class SetCameraInfoRequest(Message):
    camera_info: sensor_msgs.CameraInfo
    def __init__(self, *, camera_info: sensor_msgs.CameraInfo | Mapping[str, Any] = ...) -> None: ...

class SetCameraInfoResponse(Message):
    success: bool
    status_message: str
    def __init__(self, *, success: bool = ..., status_message: str = ...) -> None: ...

class SetCameraInfo(Service[SetCameraInfoRequest, SetCameraInfoResponse]): ...
