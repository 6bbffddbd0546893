"""The messages of Foxglove clients as values; `client_parser.py` reads them.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

from typing import Any, ClassVar

from msgspec import Struct


class ClientMessage(Struct, frozen=True):
    """A message of a client."""

    # The capability of the gateway that it needs; empty: none.
    capability: ClassVar[str] = ""


class Action(ClientMessage, frozen=True):
    """A message that acts on the robot or on the recordings: clients that may only view cannot send it."""


class Subscribe(ClientMessage, frozen=True):
    """Subscribes to channels: pairs of an id that the client chose and the channel's id."""

    subscriptions: tuple[tuple[int, int], ...]


class Unsubscribe(ClientMessage, frozen=True):
    """Ends subscriptions."""

    subscription_ids: tuple[int, ...]


class ClientChannel(Struct, frozen=True):
    """A topic that a client publishes, with the id that it chose.

    With a `driver`, a display name, it is driven under a lease.
    """

    id: int
    topic: str
    encoding: str
    schema_name: str
    schema: str
    driver: str | None = None


class Advertise(Action, frozen=True):
    """Announces that the client publishes topics."""

    capability = "clientPublish"

    channels: tuple[ClientChannel, ...]


class Unadvertise(ClientMessage, frozen=True):
    """Announces that the client stops publishing."""

    channel_ids: tuple[int, ...]


class MessageData(Action, frozen=True):
    """A message on one of the client's channels."""

    channel_id: int
    payload: bytes


class ServiceRequest(Action, frozen=True):
    """A service call."""

    capability = "services"

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


class GetParameters(ClientMessage, frozen=True):
    """Requests values; no names means all."""

    capability = "parameters"

    names: tuple[str, ...]
    request_id: str | None


class GivenParameter(Struct, frozen=True):
    """One value to set, in JSON; None unsets it."""

    name: str
    value: Any
    type: str | None


class SetParameters(Action, frozen=True):
    """Sets values."""

    capability = "parameters"

    parameters: tuple[GivenParameter, ...]
    request_id: str | None


class SubscribeParameters(ClientMessage, frozen=True):
    """Subscribes to changes of values."""

    capability = "parametersSubscribe"

    names: tuple[str, ...]


class UnsubscribeParameters(ClientMessage, frozen=True):
    """Unsubscribes from changes of values."""

    names: tuple[str, ...]


class SubscribeConnectionGraph(ClientMessage, frozen=True):
    """Subscribes to the lists of publishers, subscribers and services."""

    capability = "connectionGraph"


class UnsubscribeConnectionGraph(ClientMessage, frozen=True):
    """Unsubscribes from these lists."""


class FetchAsset(ClientMessage, frozen=True):
    """Requests a file."""

    capability = "assets"

    uri: str
    request_id: int


class ListRecordings(ClientMessage, frozen=True):
    """Requests the recordings, now and when they change; an op of this gateway."""


class StartRecording(Action, frozen=True):
    """Starts a recording; no topics means all. An op of this gateway."""

    topics: tuple[str, ...]
    form: str


class StopRecording(Action, frozen=True):
    """Ends the recording; an op of this gateway."""


class PlayRecording(Action, frozen=True):
    """Plays a recording; an op of this gateway. `start_s` is a time in the recording."""

    name: str
    start_s: float
    rate: float
    is_prefixed: bool


class PausePlayback(Action, frozen=True):
    """Pauses or continues the playback; an op of this gateway."""

    is_paused: bool


class StopPlayback(Action, frozen=True):
    """Ends the playback; an op of this gateway."""


class AskTime(ClientMessage, frozen=True):
    """Requests the robot's time; an op of this gateway. The answer has the id."""

    request_id: int
