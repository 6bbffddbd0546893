# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class EmptyRequest(Message):
    def __init__(self) -> None: ...

class EmptyResponse(Message):
    def __init__(self) -> None: ...

class Empty(Service[EmptyRequest, EmptyResponse]): ...

class SetBoolRequest(Message):
    data: bool
    def __init__(self, *, data: bool = ...) -> None: ...

class SetBoolResponse(Message):
    success: bool
    message: str
    def __init__(self, *, success: bool = ..., message: str = ...) -> None: ...

class SetBool(Service[SetBoolRequest, SetBoolResponse]): ...

class TriggerRequest(Message):
    def __init__(self) -> None: ...

class TriggerResponse(Message):
    success: bool
    message: str
    def __init__(self, *, success: bool = ..., message: str = ...) -> None: ...

class Trigger(Service[TriggerRequest, TriggerResponse]): ...
