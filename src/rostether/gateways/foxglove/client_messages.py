"""What Foxglove clients say, as values; `client_parser.py` reads them.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias


@dataclass(frozen=True, slots=True)
class Subscribe:
    """Messages of channels are wanted: pairs of an id that the client chose and the channel's."""

    subscriptions: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Unsubscribe:
    """Subscriptions end."""

    subscription_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ClientChannel:
    """A topic that a client publishes, under an id that it chose.

    With a `driver`, a name for people, it is driven under a lease.
    """

    id: int
    topic: str
    encoding: str
    schema_name: str
    schema: str
    driver: str | None = None


@dataclass(frozen=True, slots=True)
class Advertise:
    """The client publishes."""

    channels: tuple[ClientChannel, ...]


@dataclass(frozen=True, slots=True)
class Unadvertise:
    """The client publishes no more."""

    channel_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MessageData:
    """A message on one of the client's channels."""

    channel_id: int
    payload: bytes


@dataclass(frozen=True, slots=True)
class ServiceRequest:
    """A call."""

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class GetParameters:
    """Values are asked for; no names means all."""

    names: tuple[str, ...]
    request_id: str | None


@dataclass(frozen=True, slots=True)
class GivenParameter:
    """One value to set, as JSON has it; None unsets."""

    name: str
    value: Any
    type: str | None


@dataclass(frozen=True, slots=True)
class SetParameters:
    """Values are set."""

    parameters: tuple[GivenParameter, ...]
    request_id: str | None


@dataclass(frozen=True, slots=True)
class SubscribeParameters:
    """Changes of values are wanted."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnsubscribeParameters:
    """Changes of values are no longer wanted."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SubscribeConnectionGraph:
    """Who publishes, subscribes and serves is wanted."""


@dataclass(frozen=True, slots=True)
class UnsubscribeConnectionGraph:
    """It is no longer wanted."""


@dataclass(frozen=True, slots=True)
class FetchAsset:
    """A file is wanted."""

    uri: str
    request_id: int


@dataclass(frozen=True, slots=True)
class ListRecordings:
    """The recordings are wanted, now and when they change; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class StartRecording:
    """A recording is to begin; no topics means all. An op of this gateway."""

    topics: tuple[str, ...]
    form: str


@dataclass(frozen=True, slots=True)
class StopRecording:
    """The recording is to end; an op of this gateway."""


ClientMessage: TypeAlias = (
    Subscribe
    | Unsubscribe
    | Advertise
    | Unadvertise
    | MessageData
    | ServiceRequest
    | GetParameters
    | SetParameters
    | SubscribeParameters
    | UnsubscribeParameters
    | SubscribeConnectionGraph
    | UnsubscribeConnectionGraph
    | FetchAsset
    | ListRecordings
    | StartRecording
    | StopRecording
)
