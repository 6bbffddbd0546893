"""The messages of Foxglove clients as values; `client_parser.py` reads them.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias


@dataclass(frozen=True, slots=True)
class Subscribe:
    """Subscribes to channels: pairs of an id that the client chose and the channel's id."""

    subscriptions: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Unsubscribe:
    """Ends subscriptions."""

    subscription_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ClientChannel:
    """A topic that a client publishes, with the id that it chose.

    With a `driver`, a display name, it is driven under a lease.
    """

    id: int
    topic: str
    encoding: str
    schema_name: str
    schema: str
    driver: str | None = None


@dataclass(frozen=True, slots=True)
class Advertise:
    """Announces that the client publishes topics."""

    channels: tuple[ClientChannel, ...]


@dataclass(frozen=True, slots=True)
class Unadvertise:
    """Announces that the client stops publishing."""

    channel_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MessageData:
    """A message on one of the client's channels."""

    channel_id: int
    payload: bytes


@dataclass(frozen=True, slots=True)
class ServiceRequest:
    """A service call."""

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class GetParameters:
    """Requests values; no names means all."""

    names: tuple[str, ...]
    request_id: str | None


@dataclass(frozen=True, slots=True)
class GivenParameter:
    """One value to set, in JSON; None unsets it."""

    name: str
    value: Any
    type: str | None


@dataclass(frozen=True, slots=True)
class SetParameters:
    """Sets values."""

    parameters: tuple[GivenParameter, ...]
    request_id: str | None


@dataclass(frozen=True, slots=True)
class SubscribeParameters:
    """Subscribes to changes of values."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnsubscribeParameters:
    """Unsubscribes from changes of values."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SubscribeConnectionGraph:
    """Subscribes to the lists of publishers, subscribers and services."""


@dataclass(frozen=True, slots=True)
class UnsubscribeConnectionGraph:
    """Unsubscribes from these lists."""


@dataclass(frozen=True, slots=True)
class FetchAsset:
    """Requests a file."""

    uri: str
    request_id: int


@dataclass(frozen=True, slots=True)
class ListRecordings:
    """Requests the recordings, now and when they change; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class StartRecording:
    """Starts a recording; no topics means all. An op of this gateway."""

    topics: tuple[str, ...]
    form: str


@dataclass(frozen=True, slots=True)
class StopRecording:
    """Ends the recording; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class PlayRecording:
    """Plays a recording; an op of this gateway. `start_s` is a time of the recording."""

    name: str
    start_s: float
    rate: float
    is_prefixed: bool


@dataclass(frozen=True, slots=True)
class PausePlayback:
    """Pauses or continues the playback; an op of this gateway."""

    is_paused: bool


@dataclass(frozen=True, slots=True)
class StopPlayback:
    """Ends the playback; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class AskTime:
    """Requests the robot's time; an op of this gateway. The answer has the id."""

    request_id: int


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
    | PlayRecording
    | PausePlayback
    | StopPlayback
    | AskTime
)
