# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class RepublishTFsRequest(Message):
    source_frames: list[str]
    target_frame: str
    angular_thres: float
    trans_thres: float
    rate: float
    timeout: rostime.Duration
    def __init__(self, *, source_frames: Sequence[str] = ..., target_frame: str = ..., angular_thres: float = ..., trans_thres: float = ..., rate: float = ..., timeout: rostime.Duration | float = ...) -> None: ...

class RepublishTFsResponse(Message):
    topic_name: str
    def __init__(self, *, topic_name: str = ...) -> None: ...

class RepublishTFs(Service[RepublishTFsRequest, RepublishTFsResponse]): ...
