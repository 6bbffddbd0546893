# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class TwoIntsRequest(Message):
    a: int
    b: int
    def __init__(self, *, a: int = ..., b: int = ...) -> None: ...

class TwoIntsResponse(Message):
    sum: int
    def __init__(self, *, sum: int = ...) -> None: ...

class TwoInts(Service[TwoIntsRequest, TwoIntsResponse]): ...
