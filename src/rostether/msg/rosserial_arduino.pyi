# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.values import Message

class Adc(Message):
    adc0: int
    adc1: int
    adc2: int
    adc3: int
    adc4: int
    adc5: int
    def __init__(self, *, adc0: int = ..., adc1: int = ..., adc2: int = ..., adc3: int = ..., adc4: int = ..., adc5: int = ...) -> None: ...
