# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import geometry_msgs
from rostether.serde.values import Message

class tfMessage(Message):
    transforms: list[geometry_msgs.TransformStamped]
    def __init__(self, *, transforms: Sequence[geometry_msgs.TransformStamped | Mapping[str, Any]] = ...) -> None: ...
