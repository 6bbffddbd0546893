# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.values import Message

class TypeDef(Message):
    type: str
    fieldnames: list[str]
    fieldtypes: list[str]
    fieldarraylen: list[int]
    examples: list[str]
    constnames: list[str]
    constvalues: list[str]
    def __init__(self, *, type: str = ..., fieldnames: Sequence[str] = ..., fieldtypes: Sequence[str] = ..., fieldarraylen: Sequence[int] = ..., examples: Sequence[str] = ..., constnames: Sequence[str] = ..., constvalues: Sequence[str] = ...) -> None: ...
