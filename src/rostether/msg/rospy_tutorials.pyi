# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import std_msgs
from rostether.serde.values import Message

class Floats(Message):
    data: list[float]
    def __init__(self, *, data: Sequence[float] = ...) -> None: ...

class HeaderString(Message):
    header: std_msgs.Header
    data: str
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., data: str = ...) -> None: ...
