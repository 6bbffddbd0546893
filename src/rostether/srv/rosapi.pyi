# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import rosapi
from rostether.serde.type_classes import Service
from rostether.serde.values import Message

class DeleteParamRequest(Message):
    name: str
    def __init__(self, *, name: str = ...) -> None: ...

class DeleteParamResponse(Message):
    def __init__(self) -> None: ...

class DeleteParam(Service[DeleteParamRequest, DeleteParamResponse]): ...

class GetActionServersRequest(Message):
    def __init__(self) -> None: ...

class GetActionServersResponse(Message):
    action_servers: list[str]
    def __init__(self, *, action_servers: Sequence[str] = ...) -> None: ...

class GetActionServers(Service[GetActionServersRequest, GetActionServersResponse]): ...

class GetParamRequest(Message):
    name: str
    default: str
    def __init__(self, *, name: str = ..., default: str = ...) -> None: ...

class GetParamResponse(Message):
    value: str
    def __init__(self, *, value: str = ...) -> None: ...

class GetParam(Service[GetParamRequest, GetParamResponse]): ...

class GetParamNamesRequest(Message):
    def __init__(self) -> None: ...

class GetParamNamesResponse(Message):
    names: list[str]
    def __init__(self, *, names: Sequence[str] = ...) -> None: ...

class GetParamNames(Service[GetParamNamesRequest, GetParamNamesResponse]): ...

class GetROSVersionRequest(Message):
    def __init__(self) -> None: ...

class GetROSVersionResponse(Message):
    version: int
    distro: str
    def __init__(self, *, version: int = ..., distro: str = ...) -> None: ...

class GetROSVersion(Service[GetROSVersionRequest, GetROSVersionResponse]): ...

class GetTimeRequest(Message):
    def __init__(self) -> None: ...

class GetTimeResponse(Message):
    time: rostime.Time
    def __init__(self, *, time: rostime.Time | float | Literal["now"] = ...) -> None: ...

class GetTime(Service[GetTimeRequest, GetTimeResponse]): ...

class HasParamRequest(Message):
    name: str
    def __init__(self, *, name: str = ...) -> None: ...

class HasParamResponse(Message):
    exists: bool
    def __init__(self, *, exists: bool = ...) -> None: ...

class HasParam(Service[HasParamRequest, HasParamResponse]): ...

class MessageDetailsRequest(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class MessageDetailsResponse(Message):
    typedefs: list[rosapi.TypeDef]
    def __init__(self, *, typedefs: Sequence[rosapi.TypeDef | Mapping[str, Any]] = ...) -> None: ...

class MessageDetails(Service[MessageDetailsRequest, MessageDetailsResponse]): ...

class NodeDetailsRequest(Message):
    node: str
    def __init__(self, *, node: str = ...) -> None: ...

class NodeDetailsResponse(Message):
    subscribing: list[str]
    publishing: list[str]
    services: list[str]
    def __init__(self, *, subscribing: Sequence[str] = ..., publishing: Sequence[str] = ..., services: Sequence[str] = ...) -> None: ...

class NodeDetails(Service[NodeDetailsRequest, NodeDetailsResponse]): ...

class NodesRequest(Message):
    def __init__(self) -> None: ...

class NodesResponse(Message):
    nodes: list[str]
    def __init__(self, *, nodes: Sequence[str] = ...) -> None: ...

class Nodes(Service[NodesRequest, NodesResponse]): ...

class PublishersRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class PublishersResponse(Message):
    publishers: list[str]
    def __init__(self, *, publishers: Sequence[str] = ...) -> None: ...

class Publishers(Service[PublishersRequest, PublishersResponse]): ...

class SearchParamRequest(Message):
    name: str
    def __init__(self, *, name: str = ...) -> None: ...

class SearchParamResponse(Message):
    global_name: str
    def __init__(self, *, global_name: str = ...) -> None: ...

class SearchParam(Service[SearchParamRequest, SearchParamResponse]): ...

class ServiceHostRequest(Message):
    service: str
    def __init__(self, *, service: str = ...) -> None: ...

class ServiceHostResponse(Message):
    host: str
    def __init__(self, *, host: str = ...) -> None: ...

class ServiceHost(Service[ServiceHostRequest, ServiceHostResponse]): ...

class ServiceNodeRequest(Message):
    service: str
    def __init__(self, *, service: str = ...) -> None: ...

class ServiceNodeResponse(Message):
    node: str
    def __init__(self, *, node: str = ...) -> None: ...

class ServiceNode(Service[ServiceNodeRequest, ServiceNodeResponse]): ...

class ServiceProvidersRequest(Message):
    service: str
    def __init__(self, *, service: str = ...) -> None: ...

class ServiceProvidersResponse(Message):
    providers: list[str]
    def __init__(self, *, providers: Sequence[str] = ...) -> None: ...

class ServiceProviders(Service[ServiceProvidersRequest, ServiceProvidersResponse]): ...

class ServiceRequestDetailsRequest(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class ServiceRequestDetailsResponse(Message):
    typedefs: list[rosapi.TypeDef]
    def __init__(self, *, typedefs: Sequence[rosapi.TypeDef | Mapping[str, Any]] = ...) -> None: ...

class ServiceRequestDetails(Service[ServiceRequestDetailsRequest, ServiceRequestDetailsResponse]): ...

class ServiceResponseDetailsRequest(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class ServiceResponseDetailsResponse(Message):
    typedefs: list[rosapi.TypeDef]
    def __init__(self, *, typedefs: Sequence[rosapi.TypeDef | Mapping[str, Any]] = ...) -> None: ...

class ServiceResponseDetails(Service[ServiceResponseDetailsRequest, ServiceResponseDetailsResponse]): ...

class ServiceTypeRequest(Message):
    service: str
    def __init__(self, *, service: str = ...) -> None: ...

class ServiceTypeResponse(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class ServiceType(Service[ServiceTypeRequest, ServiceTypeResponse]): ...

class ServicesRequest(Message):
    def __init__(self) -> None: ...

class ServicesResponse(Message):
    services: list[str]
    def __init__(self, *, services: Sequence[str] = ...) -> None: ...

class Services(Service[ServicesRequest, ServicesResponse]): ...

class ServicesForTypeRequest(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class ServicesForTypeResponse(Message):
    services: list[str]
    def __init__(self, *, services: Sequence[str] = ...) -> None: ...

class ServicesForType(Service[ServicesForTypeRequest, ServicesForTypeResponse]): ...

class SetParamRequest(Message):
    name: str
    value: str
    def __init__(self, *, name: str = ..., value: str = ...) -> None: ...

class SetParamResponse(Message):
    def __init__(self) -> None: ...

class SetParam(Service[SetParamRequest, SetParamResponse]): ...

class SubscribersRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class SubscribersResponse(Message):
    subscribers: list[str]
    def __init__(self, *, subscribers: Sequence[str] = ...) -> None: ...

class Subscribers(Service[SubscribersRequest, SubscribersResponse]): ...

class TopicTypeRequest(Message):
    topic: str
    def __init__(self, *, topic: str = ...) -> None: ...

class TopicTypeResponse(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class TopicType(Service[TopicTypeRequest, TopicTypeResponse]): ...

class TopicsRequest(Message):
    def __init__(self) -> None: ...

class TopicsResponse(Message):
    topics: list[str]
    types: list[str]
    def __init__(self, *, topics: Sequence[str] = ..., types: Sequence[str] = ...) -> None: ...

class Topics(Service[TopicsRequest, TopicsResponse]): ...

class TopicsAndRawTypesRequest(Message):
    def __init__(self) -> None: ...

class TopicsAndRawTypesResponse(Message):
    topics: list[str]
    types: list[str]
    typedefs_full_text: list[str]
    def __init__(self, *, topics: Sequence[str] = ..., types: Sequence[str] = ..., typedefs_full_text: Sequence[str] = ...) -> None: ...

class TopicsAndRawTypes(Service[TopicsAndRawTypesRequest, TopicsAndRawTypesResponse]): ...

class TopicsForTypeRequest(Message):
    type: str
    def __init__(self, *, type: str = ...) -> None: ...

class TopicsForTypeResponse(Message):
    topics: list[str]
    def __init__(self, *, topics: Sequence[str] = ...) -> None: ...

class TopicsForType(Service[TopicsForTypeRequest, TopicsForTypeResponse]): ...
