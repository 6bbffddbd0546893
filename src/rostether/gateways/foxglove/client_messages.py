"""The messages of Foxglove clients as values; `client_parser.py` reads them.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar


class ClientMessage:
    """A message of a client."""

    __slots__ = ()

    # The capability of the gateway that it needs; empty: none.
    capability: ClassVar[str] = ""


class Action(ClientMessage):
    """A message that acts on the robot or on the recordings: clients that may only view cannot send it."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Subscribe(ClientMessage):
    """Subscribes to channels: pairs of an id that the client chose and the channel's id."""

    subscriptions: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Unsubscribe(ClientMessage):
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
class Advertise(Action):
    """Announces that the client publishes topics."""

    capability = "clientPublish"

    channels: tuple[ClientChannel, ...]


@dataclass(frozen=True, slots=True)
class Unadvertise(ClientMessage):
    """Announces that the client stops publishing."""

    channel_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MessageData(Action):
    """A message on one of the client's channels."""

    channel_id: int
    payload: bytes


@dataclass(frozen=True, slots=True)
class ServiceRequest(Action):
    """A service call."""

    capability = "services"

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class GetParameters(ClientMessage):
    """Requests values; no names means all."""

    capability = "parameters"

    names: tuple[str, ...]
    request_id: str | None


@dataclass(frozen=True, slots=True)
class GivenParameter:
    """One value to set, in JSON; None unsets it."""

    name: str
    value: Any
    type: str | None


@dataclass(frozen=True, slots=True)
class SetParameters(Action):
    """Sets values."""

    capability = "parameters"

    parameters: tuple[GivenParameter, ...]
    request_id: str | None


@dataclass(frozen=True, slots=True)
class SubscribeParameters(ClientMessage):
    """Subscribes to changes of values."""

    capability = "parametersSubscribe"

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnsubscribeParameters(ClientMessage):
    """Unsubscribes from changes of values."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SubscribeConnectionGraph(ClientMessage):
    """Subscribes to the lists of publishers, subscribers and services."""

    capability = "connectionGraph"


@dataclass(frozen=True, slots=True)
class UnsubscribeConnectionGraph(ClientMessage):
    """Unsubscribes from these lists."""


@dataclass(frozen=True, slots=True)
class FetchAsset(ClientMessage):
    """Requests a file."""

    capability = "assets"

    uri: str
    request_id: int


@dataclass(frozen=True, slots=True)
class ListRecordings(ClientMessage):
    """Requests the recordings, now and when they change; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class StartRecording(Action):
    """Starts a recording; no topics means all. An op of this gateway."""

    topics: tuple[str, ...]
    form: str


@dataclass(frozen=True, slots=True)
class StopRecording(Action):
    """Ends the recording; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class PlayRecording(Action):
    """Plays a recording; an op of this gateway. `start_s` is a time in the recording."""

    name: str
    start_s: float
    rate: float
    is_prefixed: bool


@dataclass(frozen=True, slots=True)
class PausePlayback(Action):
    """Pauses or continues the playback; an op of this gateway."""

    is_paused: bool


@dataclass(frozen=True, slots=True)
class StopPlayback(Action):
    """Ends the playback; an op of this gateway."""


@dataclass(frozen=True, slots=True)
class AskTime(ClientMessage):
    """Requests the robot's time; an op of this gateway. The answer has the id."""

    request_id: int
