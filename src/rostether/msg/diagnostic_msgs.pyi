# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import std_msgs
from rostether.serde.values import Message

class DiagnosticArray(Message):
    header: std_msgs.Header
    status: list[DiagnosticStatus]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: Sequence[DiagnosticStatus | Mapping[str, Any]] = ...) -> None: ...

class DiagnosticStatus(Message):
    OK: int
    WARN: int
    ERROR: int
    STALE: int
    level: int
    name: str
    message: str
    hardware_id: str
    values: list[KeyValue]
    def __init__(self, *, level: int = ..., name: str = ..., message: str = ..., hardware_id: str = ..., values: Sequence[KeyValue | Mapping[str, Any]] = ...) -> None: ...

class KeyValue(Message):
    key: str
    value: str
    def __init__(self, *, key: str = ..., value: str = ...) -> None: ...
