# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.values import Message

class ArduinoControl(Message):
    dir: float
    speed: float
    def __init__(self, *, dir: float = ..., speed: float = ...) -> None: ...
