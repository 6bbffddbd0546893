# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import diagnostic_msgs
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class AddDiagnosticsRequest(Message):
    load_namespace: str
    def __init__(self, *, load_namespace: str = ...) -> None: ...

class AddDiagnosticsResponse(Message):
    success: bool
    message: str
    def __init__(self, *, success: bool = ..., message: str = ...) -> None: ...

class AddDiagnostics(Service[AddDiagnosticsRequest, AddDiagnosticsResponse]): ...

class SelfTestRequest(Message):
    def __init__(self) -> None: ...

class SelfTestResponse(Message):
    id: str
    passed: int
    status: list[diagnostic_msgs.DiagnosticStatus]
    def __init__(self, *, id: str = ..., passed: int = ..., status: Sequence[diagnostic_msgs.DiagnosticStatus | Mapping[str, Any]] = ...) -> None: ...

class SelfTest(Service[SelfTestRequest, SelfTestResponse]): ...
