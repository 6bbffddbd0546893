# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import roscpp
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class EmptyRequest(Message):
    def __init__(self) -> None: ...

class EmptyResponse(Message):
    def __init__(self) -> None: ...

class Empty(Service[EmptyRequest, EmptyResponse]): ...

class GetLoggersRequest(Message):
    def __init__(self) -> None: ...

class GetLoggersResponse(Message):
    loggers: list[roscpp.Logger]
    def __init__(self, *, loggers: Sequence[roscpp.Logger | Mapping[str, Any]] = ...) -> None: ...

class GetLoggers(Service[GetLoggersRequest, GetLoggersResponse]): ...

class SetLoggerLevelRequest(Message):
    logger: str
    level: str
    def __init__(self, *, logger: str = ..., level: str = ...) -> None: ...

class SetLoggerLevelResponse(Message):
    def __init__(self) -> None: ...

class SetLoggerLevel(Service[SetLoggerLevelRequest, SetLoggerLevelResponse]): ...
