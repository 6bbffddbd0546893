# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class RequestMessageInfoRequest(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class RequestMessageInfoResponse(Message):
    md5: str
    definition: str
    def __init__(self, *, md5: str = ..., definition: str = ...) -> None: ...

class RequestMessageInfo(Service[RequestMessageInfoRequest, RequestMessageInfoResponse]): ...

class RequestParamRequest(Message):
    name: str
    def __init__(self, *, name: str = ...) -> None: ...

class RequestParamResponse(Message):
    ints: list[int]
    floats: list[float]
    strings: list[str]
    def __init__(self, *, ints: Sequence[int] = ..., floats: Sequence[float] = ..., strings: Sequence[str] = ...) -> None: ...

class RequestParam(Service[RequestParamRequest, RequestParamResponse]): ...

class RequestServiceInfoRequest(Message):
    service: str
    def __init__(self, *, service: str = ...) -> None: ...

class RequestServiceInfoResponse(Message):
    service_md5: str
    request_md5: str
    response_md5: str
    def __init__(self, *, service_md5: str = ..., request_md5: str = ..., response_md5: str = ...) -> None: ...

class RequestServiceInfo(Service[RequestServiceInfoRequest, RequestServiceInfoResponse]): ...
