"""Parses and checks messages of Foxglove clients: JSON objects by `op`, binary messages by opcode.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

import base64
import binascii
import struct
from collections.abc import Callable
from typing import Any

from rostether.errors import RemoteProtocolError
from rostether.gateways.foxglove import client_messages as requests
from rostether.gateways.large_json import check_few_values, parse_json
from rostether.gateways.shown_values import show

# Subscriptions, channels or names in one message; a large system has a few thousand topics.
MAX_ITEMS = 4096

# Checking a longer text takes longer than 10 ms. The longest texts set a robot description of a few MB.
MAX_TEXT_MESSAGE_CHARACTERS = 4 << 20

# The limit of a name, an encoding or an id; ROS names have less than 256 characters.
MAX_TEXT_CHARACTERS = 4096

_MESSAGE_DATA, _SERVICE_REQUEST = 0x01, 0x02
_CHANNEL_ID = struct.Struct("<BI")
_SERVICE_HEADER = struct.Struct("<BIII")
_MAX_ID = (1 << 32) - 1
# Seconds of a recording: a century.
_MAX_NUMBER = 3.2e9


def parse_binary(data: bytes) -> requests.MessageData | requests.ServiceRequest:
    """Return a binary message. Raises RemoteProtocolError."""
    opcode = data[0] if data else -1
    if opcode == _MESSAGE_DATA and len(data) >= _CHANNEL_ID.size:
        return requests.MessageData(_CHANNEL_ID.unpack_from(data)[1], data[_CHANNEL_ID.size :])
    if opcode == _SERVICE_REQUEST and len(data) >= _SERVICE_HEADER.size:
        _, service_id, call_id, encoding_bytes = _SERVICE_HEADER.unpack_from(data)
        start = _SERVICE_HEADER.size + encoding_bytes
        if encoding_bytes <= MAX_TEXT_CHARACTERS and start <= len(data):
            encoding = data[_SERVICE_HEADER.size : start].decode("utf-8", "replace")
            return requests.ServiceRequest(service_id, call_id, encoding, data[start:])
    raise RemoteProtocolError(
        f"a binary message of {len(data)} bytes with opcode {opcode} is not part of the protocol"
    )


def parse_text(text: str) -> requests.ClientMessage:
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
        raise RemoteProtocolError("a text message is not a JSON object with an op")
    op = message.get("op")
    parse = _PARSERS.get(op) if isinstance(op, str) else None
    if parse is None:
        raise RemoteProtocolError(f"unknown op {show(op)}; known: {', '.join(_PARSERS)}")
    return parse(_Fields(str(op), message))


class _Fields:
    """The fields of one JSON object, each read with its required type."""

    def __init__(self, where: str, fields: dict[str, Any]) -> None:
        self._where = where
        self._fields = fields

    def id(self, name: str) -> int:
        value = self._fields.get(name)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MAX_ID:
            raise self._wrong(name, "an unsigned 32-bit number")
        return value

    def ids(self, name: str) -> tuple[int, ...]:
        return tuple(_Fields(self._where, {name: each}).id(name) for each in self._list(name))

    def text(self, name: str) -> str:
        value = self._fields.get(name)
        if not isinstance(value, str) or len(value) > MAX_TEXT_CHARACTERS:
            raise self._wrong(name, "a string")
        return value

    def optional_text(self, name: str) -> str | None:
        return None if self._fields.get(name) is None else self.text(name)

    def number(self, name: str, otherwise: float) -> float:
        value = self._fields.get(name, otherwise)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= _MAX_NUMBER:
            raise self._wrong(name, "a number of 0 or more")
        return float(value)

    def flag(self, name: str, *, default: bool) -> bool:
        value = self._fields.get(name, default)
        if not isinstance(value, bool):
            raise self._wrong(name, "true or false")
        return value

    def texts(self, name: str) -> tuple[str, ...]:
        return tuple(_Fields(self._where, {name: each}).text(name) for each in self._list(name))

    def objects(self, name: str) -> list[_Fields]:
        objects = self._list(name)
        if not all(isinstance(each, dict) for each in objects):
            raise self._wrong(name, "a list of objects")
        return [_Fields(f"{self._where}.{name}", each) for each in objects]

    def value(self, name: str) -> Any:
        return self._fields.get(name)

    def schema(self) -> str:
        value = self._fields.get("schema")
        if value is None:
            return ""
        if not isinstance(value, str):
            raise self._wrong("schema", "a string")
        if self._fields.get("schemaEncoding") != "ros1msg" and self._fields.get("encoding") != "ros1":
            return ""
        return value

    def _list(self, name: str) -> list[Any]:
        value = self._fields.get(name)
        if not isinstance(value, list) or len(value) > MAX_ITEMS:
            raise self._wrong(name, f"a list of at most {MAX_ITEMS}")
        return value

    def _wrong(self, name: str, wanted: str) -> RemoteProtocolError:
        return RemoteProtocolError(f"{self._where} needs {wanted} as {name}, not {self._shown(name)}")

    def _shown(self, name: str) -> str:
        return show(self._fields.get(name))


def _client_channel(fields: _Fields) -> requests.ClientChannel:
    return requests.ClientChannel(
        fields.id("id"),
        fields.text("topic"),
        fields.text("encoding"),
        fields.text("schemaName"),
        fields.schema(),
        fields.optional_text("driver"),
    )


def _given_parameter(fields: _Fields) -> requests.GivenParameter:
    name, value, kind = fields.text("name"), fields.value("value"), fields.optional_text("type")
    if kind == "byte_array" and value is not None:
        try:
            value = base64.b64decode(value, validate=True)
        except (binascii.Error, ValueError, TypeError):
            raise RemoteProtocolError(
                f"parameter {name[:80]} is not a byte_array: it is not base64"
            ) from None
    return requests.GivenParameter(name, value, kind)


_PARSERS: dict[str, Callable[[_Fields], requests.ClientMessage]] = {
    "subscribe": lambda fields: requests.Subscribe(
        tuple((each.id("id"), each.id("channelId")) for each in fields.objects("subscriptions"))
    ),
    "unsubscribe": lambda fields: requests.Unsubscribe(fields.ids("subscriptionIds")),
    "advertise": lambda fields: requests.Advertise(tuple(map(_client_channel, fields.objects("channels")))),
    "unadvertise": lambda fields: requests.Unadvertise(fields.ids("channelIds")),
    "getParameters": lambda fields: requests.GetParameters(
        fields.texts("parameterNames"), fields.optional_text("id")
    ),
    "setParameters": lambda fields: requests.SetParameters(
        tuple(map(_given_parameter, fields.objects("parameters"))), fields.optional_text("id")
    ),
    "subscribeParameterUpdates": lambda fields: requests.SubscribeParameters(fields.texts("parameterNames")),
    "unsubscribeParameterUpdates": lambda fields: requests.UnsubscribeParameters(
        fields.texts("parameterNames")
    ),
    "subscribeConnectionGraph": lambda _: requests.SubscribeConnectionGraph(),
    "unsubscribeConnectionGraph": lambda _: requests.UnsubscribeConnectionGraph(),
    "listRecordings": lambda _: requests.ListRecordings(),
    "startRecording": lambda fields: requests.StartRecording(
        fields.texts("topics") if fields.value("topics") is not None else (),
        fields.optional_text("format") or "bag",
    ),
    "stopRecording": lambda _: requests.StopRecording(),
    "playRecording": lambda fields: requests.PlayRecording(
        fields.text("name"),
        fields.number("start", 0.0),
        fields.number("rate", 1.0),
        fields.flag("prefixed", default=True),
    ),
    "pausePlayback": lambda fields: requests.PausePlayback(fields.flag("paused", default=True)),
    "stopPlayback": lambda _: requests.StopPlayback(),
    "askTime": lambda fields: requests.AskTime(fields.id("id")),
    "fetchAsset": lambda fields: requests.FetchAsset(fields.text("uri"), fields.id("requestId")),
}
