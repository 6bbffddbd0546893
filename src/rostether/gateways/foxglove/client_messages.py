"""The messages of Foxglove clients, parsed and checked: JSON objects by `op`, binary messages by opcode.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

import struct
from typing import Annotated, Any, ClassVar, TypeAlias

import msgspec
from msgspec import Meta, Struct, field

from rostether.errors import RemoteProtocolError
from rostether.gateways.client_json import check_few_values, parse_json, show
from rostether.mechanisms.json_fault import explain_fault
from rostether.mechanisms.text import counted

# Subscriptions, channels or names in one message; a large system has a few thousand topics.
MAX_ITEMS = 4096

# The limit of a name, an encoding or an id; ROS names have fewer than 256 characters.
MAX_TEXT_CHARACTERS = 4096

# Seconds of a recording: a century.
_MAX_NUMBER = 3.2e9

_Id: TypeAlias = Annotated[int, Meta(ge=0, lt=1 << 32)]
_Text: TypeAlias = Annotated[str, Meta(max_length=MAX_TEXT_CHARACTERS)]
_Number: TypeAlias = Annotated[float, Meta(ge=0, le=_MAX_NUMBER)]
_Few = Meta(max_length=MAX_ITEMS)
_Ids: TypeAlias = Annotated[tuple[_Id, ...], _Few]
_Texts: TypeAlias = Annotated[tuple[_Text, ...], _Few]


class ClientMessage(Struct, frozen=True, rename="camel"):
    """A message of a client."""

    # The capability that the gateway must have for it; empty if it needs none.
    capability: ClassVar[str] = ""


class Action(ClientMessage, frozen=True):
    """A message that acts on the robot or on the recordings: clients that may only view cannot send it."""


class GivenSubscription(Struct, frozen=True, rename="camel"):
    """A subscription to a channel, with the id that the client chose."""

    id: _Id
    channel_id: _Id


class Subscribe(ClientMessage, frozen=True):
    """Subscribes to channels."""

    subscriptions: Annotated[tuple[GivenSubscription, ...], _Few]


class Unsubscribe(ClientMessage, frozen=True):
    """Ends subscriptions."""

    subscription_ids: _Ids


class ClientChannel(Struct, frozen=True, rename="camel"):
    """A topic that a client publishes, with the id that it chose.

    With a `driver`, a display name, it is driven under a lease.
    """

    id: _Id
    topic: _Text
    encoding: _Text
    schema_name: _Text
    schema: str | None = None
    schema_encoding: str | None = None
    driver: _Text | None = None

    @property
    def definition(self) -> str | None:
        """The definition of the type in ROS 1's format."""
        return self.schema if self.schema_encoding == "ros1msg" or self.encoding == "ros1" else None


class Advertise(Action, frozen=True):
    """Announces that the client publishes topics."""

    capability = "clientPublish"

    channels: Annotated[tuple[ClientChannel, ...], _Few]


class Unadvertise(ClientMessage, frozen=True):
    """Announces that the client stops publishing."""

    channel_ids: _Ids


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
    """Requests the values of the named parameters, or of all if none are named."""

    capability = "parameters"

    parameter_names: _Texts
    id: _Text | None = None


class GivenParameter(Struct, frozen=True):
    """One parameter and its new value, in JSON; None unsets it."""

    name: _Text
    value: Any = None
    type: _Text | None = None


class SetParameters(Action, frozen=True):
    """Sets parameters."""

    capability = "parameters"

    parameters: Annotated[tuple[GivenParameter, ...], _Few]
    id: _Text | None = None


class SubscribeParameters(ClientMessage, frozen=True):
    """Subscribes to changes of the named parameters, or of all if none are named."""

    capability = "parametersSubscribe"

    parameter_names: _Texts


class UnsubscribeParameters(ClientMessage, frozen=True):
    """Unsubscribes from changes of the named parameters, or of all if none are named."""

    parameter_names: _Texts


class SubscribeConnectionGraph(ClientMessage, frozen=True):
    """Subscribes to the lists of publishers, subscribers and services."""

    capability = "connectionGraph"


class UnsubscribeConnectionGraph(ClientMessage, frozen=True):
    """Unsubscribes from these lists."""


class FetchAsset(ClientMessage, frozen=True):
    """Requests a file."""

    capability = "assets"

    uri: _Text
    request_id: _Id


class ListRecordings(ClientMessage, frozen=True):
    """Requests the recordings, now and when they change; an op of this gateway."""


class StartRecording(Action, frozen=True):
    """Starts a recording of the topics, or of all if none are given; an op of this gateway."""

    topics: _Texts = ()
    format: _Text = "bag"


class StopRecording(Action, frozen=True):
    """Ends the recording; an op of this gateway."""


class PlayRecording(Action, frozen=True):
    """Plays a recording; an op of this gateway. `start_s` is a time in the recording."""

    name: _Text
    start_s: _Number = field(name="start", default=0.0)
    rate: _Number = 1.0
    is_prefixed: bool = field(name="prefixed", default=True)


class PausePlayback(Action, frozen=True):
    """Pauses or continues the playback; an op of this gateway."""

    is_paused: bool = field(name="paused", default=True)


class StopPlayback(Action, frozen=True):
    """Ends the playback; an op of this gateway."""


class AskTime(ClientMessage, frozen=True):
    """Requests the robot's time; an op of this gateway. The answer has the id."""

    id: _Id


# Checking a longer text takes longer than 10 ms. The longest texts set a robot description of a few MB.
MAX_TEXT_MESSAGE_CHARACTERS = 4 << 20

_MESSAGE_DATA, _SERVICE_REQUEST = 0x01, 0x02
_CHANNEL_ID = struct.Struct("<BI")
_SERVICE_HEADER = struct.Struct("<BIII")


def parse_binary(data: bytes) -> MessageData | ServiceRequest:
    """Return a binary message. Raises RemoteProtocolError."""
    opcode = data[0] if data else None
    if opcode == _MESSAGE_DATA and len(data) >= _CHANNEL_ID.size:
        return MessageData(_CHANNEL_ID.unpack_from(data)[1], data[_CHANNEL_ID.size :])
    if opcode == _SERVICE_REQUEST and len(data) >= _SERVICE_HEADER.size:
        _, service_id, call_id, encoding_bytes = _SERVICE_HEADER.unpack_from(data)
        start = _SERVICE_HEADER.size + encoding_bytes
        if encoding_bytes <= MAX_TEXT_CHARACTERS and start <= len(data):
            encoding = data[_SERVICE_HEADER.size : start].decode("utf-8", "replace")
            return ServiceRequest(service_id, call_id, encoding, data[start:])
    if opcode in (_MESSAGE_DATA, _SERVICE_REQUEST):
        raise RemoteProtocolError(
            f"a binary message with opcode {opcode} ends early: it has {counted(len(data), 'byte')}"
        )
    raise RemoteProtocolError(
        f"a binary message must begin with {_MESSAGE_DATA} (message data) or {_SERVICE_REQUEST} "
        f"(service request){'; it is empty' if opcode is None else f', not {opcode}'}"
    )


def parse_text(text: str) -> ClientMessage:
    """Return a JSON message. Raises RemoteProtocolError with the reason."""
    if len(text) > MAX_TEXT_MESSAGE_CHARACTERS:
        raise RemoteProtocolError(
            f"a text message may have at most {MAX_TEXT_MESSAGE_CHARACTERS} characters, not {len(text)}"
        )
    check_few_values(text)
    try:
        message = parse_json(text)
    except (ValueError, RecursionError) as error:
        raise RemoteProtocolError(f"a text message is not JSON: {error}") from None
    if not isinstance(message, dict):
        raise RemoteProtocolError("a text message must be a JSON object with an op")
    op = message.get("op")
    message_type = _MESSAGES.get(op) if isinstance(op, str) else None
    if message_type is None:
        raise RemoteProtocolError(f"unknown op {show(op)}; known: {', '.join(_MESSAGES)}")
    try:
        return msgspec.convert(message, message_type)
    except msgspec.ValidationError as error:
        raise RemoteProtocolError(f"{op}: {explain_fault(error)}") from None


_MESSAGES: dict[str, type[ClientMessage]] = {
    "subscribe": Subscribe,
    "unsubscribe": Unsubscribe,
    "advertise": Advertise,
    "unadvertise": Unadvertise,
    "getParameters": GetParameters,
    "setParameters": SetParameters,
    "subscribeParameterUpdates": SubscribeParameters,
    "unsubscribeParameterUpdates": UnsubscribeParameters,
    "subscribeConnectionGraph": SubscribeConnectionGraph,
    "unsubscribeConnectionGraph": UnsubscribeConnectionGraph,
    "listRecordings": ListRecordings,
    "startRecording": StartRecording,
    "stopRecording": StopRecording,
    "playRecording": PlayRecording,
    "pausePlayback": PausePlayback,
    "stopPlayback": StopPlayback,
    "askTime": AskTime,
    "fetchAsset": FetchAsset,
}
