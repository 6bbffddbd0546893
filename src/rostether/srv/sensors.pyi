# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class RegistrationServiceRequest(Message):
    CAMERA: str
    ANALOG: str
    DIGITAL: str
    platform_name: str
    sensor_type: str
    def __init__(self, *, platform_name: str = ..., sensor_type: str = ...) -> None: ...

class RegistrationServiceResponse(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class RegistrationService(Service[RegistrationServiceRequest, RegistrationServiceResponse]): ...
