# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class DemuxAddRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class DemuxAddResponse(Message):
    def __init__(self) -> None: ...

class DemuxAdd(Service[DemuxAddRequest, DemuxAddResponse]): ...

class DemuxDeleteRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class DemuxDeleteResponse(Message):
    def __init__(self) -> None: ...

class DemuxDelete(Service[DemuxDeleteRequest, DemuxDeleteResponse]): ...

class DemuxListRequest(Message):
    def __init__(self) -> None: ...

class DemuxListResponse(Message):
    topics: list[str]
    def __init__(self, *, topics: Sequence[str] = ...) -> None: ...

class DemuxList(Service[DemuxListRequest, DemuxListResponse]): ...

class DemuxSelectRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class DemuxSelectResponse(Message):
    prev_topic: str
    def __init__(self, *, prev_topic: str = ...) -> None: ...

class DemuxSelect(Service[DemuxSelectRequest, DemuxSelectResponse]): ...

class MuxAddRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class MuxAddResponse(Message):
    def __init__(self) -> None: ...

class MuxAdd(Service[MuxAddRequest, MuxAddResponse]): ...

class MuxDeleteRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class MuxDeleteResponse(Message):
    def __init__(self) -> None: ...

class MuxDelete(Service[MuxDeleteRequest, MuxDeleteResponse]): ...

class MuxListRequest(Message):
    def __init__(self) -> None: ...

class MuxListResponse(Message):
    topics: list[str]
    def __init__(self, *, topics: Sequence[str] = ...) -> None: ...

class MuxList(Service[MuxListRequest, MuxListResponse]): ...

class MuxSelectRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class MuxSelectResponse(Message):
    prev_topic: str
    def __init__(self, *, prev_topic: str = ...) -> None: ...

class MuxSelect(Service[MuxSelectRequest, MuxSelectResponse]): ...
