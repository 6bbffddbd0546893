# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class FrameGraphRequest(Message):
    def __init__(self) -> None: ...

class FrameGraphResponse(Message):
    dot_graph: str
    def __init__(self, *, dot_graph: str = ...) -> None: ...

class FrameGraph(Service[FrameGraphRequest, FrameGraphResponse]): ...
