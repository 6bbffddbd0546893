# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.values import Message

class Logger(Message):
    name: str
    level: str
    def __init__(self, *, name: str = ..., level: str = ...) -> None: ...
