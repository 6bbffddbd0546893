# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.values import Message

class Log(Message):
    ROSDEBUG: int
    INFO: int
    WARN: int
    ERROR: int
    FATAL: int
    level: int
    msg: str
    def __init__(self, *, level: int = ..., msg: str = ...) -> None: ...

class TopicInfo(Message):
    ID_PUBLISHER: int
    ID_SUBSCRIBER: int
    ID_SERVICE_SERVER: int
    ID_SERVICE_CLIENT: int
    ID_PARAMETER_REQUEST: int
    ID_LOG: int
    ID_TIME: int
    ID_TX_STOP: int
    topic_id: int
    topic_name: str
    message_type: str
    md5sum: str
    buffer_size: int
    def __init__(self, *, topic_id: int = ..., topic_name: str = ..., message_type: str = ..., md5sum: str = ..., buffer_size: int = ...) -> None: ...
