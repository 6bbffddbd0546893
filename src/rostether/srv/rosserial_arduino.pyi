# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class TestRequest(Message):
    input: str
    def __init__(self, *, input: str = ...) -> None: ...

class TestResponse(Message):
    output: str
    def __init__(self, *, output: str = ...) -> None: ...

class Test(Service[TestRequest, TestResponse]): ...
