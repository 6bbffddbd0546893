# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class FrameGraphRequest(Message):
    def __init__(self) -> None: ...

class FrameGraphResponse(Message):
    frame_yaml: str
    def __init__(self, *, frame_yaml: str = ...) -> None: ...

class FrameGraph(Service[FrameGraphRequest, FrameGraphResponse]): ...
