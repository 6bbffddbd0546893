"""Parses and checks messages of Foxglove clients: JSON objects by `op`, binary messages by opcode.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
"""

from __future__ import annotations

import struct

import msgspec

from rostether.errors import RemoteProtocolError
from rostether.gateways.foxglove import client_messages as requests
from rostether.gateways.large_json import check_few_values, parse_json
from rostether.gateways.shown_values import show
from rostether.mechanisms.json_fault import explain_fault
from rostether.mechanisms.text import counted

# Checking a longer text takes longer than 10 ms. The longest texts set a robot description of a few MB.
MAX_TEXT_MESSAGE_CHARACTERS = 4 << 20

_MESSAGE_DATA, _SERVICE_REQUEST = 0x01, 0x02
_CHANNEL_ID = struct.Struct("<BI")
_SERVICE_HEADER = struct.Struct("<BIII")


def parse_binary(data: bytes) -> requests.MessageData | requests.ServiceRequest:
    """Return a binary message. Raises RemoteProtocolError."""
    opcode = data[0] if data else None
    if opcode == _MESSAGE_DATA and len(data) >= _CHANNEL_ID.size:
        return requests.MessageData(_CHANNEL_ID.unpack_from(data)[1], data[_CHANNEL_ID.size :])
    if opcode == _SERVICE_REQUEST and len(data) >= _SERVICE_HEADER.size:
        _, service_id, call_id, encoding_bytes = _SERVICE_HEADER.unpack_from(data)
        start = _SERVICE_HEADER.size + encoding_bytes
        if encoding_bytes <= requests.MAX_TEXT_CHARACTERS and start <= len(data):
            encoding = data[_SERVICE_HEADER.size : start].decode("utf-8", "replace")
            return requests.ServiceRequest(service_id, call_id, encoding, data[start:])
    if opcode in (_MESSAGE_DATA, _SERVICE_REQUEST):
        raise RemoteProtocolError(
            f"a binary message with opcode {opcode} ends early: it has {counted(len(data), 'byte')}"
        )
    raise RemoteProtocolError(
        f"a binary message must begin with {_MESSAGE_DATA} (message data) or {_SERVICE_REQUEST} "
        f"(service request){'; it is empty' if opcode is None else f', not {opcode}'}"
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
        raise RemoteProtocolError("a text message must be a JSON object with an op")
    op = message.get("op")
    message_type = _MESSAGES.get(op) if isinstance(op, str) else None
    if message_type is None:
        raise RemoteProtocolError(f"unknown op {show(op)}; known: {', '.join(_MESSAGES)}")
    try:
        return msgspec.convert(message, message_type)
    except msgspec.ValidationError as error:
        raise RemoteProtocolError(f"{op}: {explain_fault(error)}") from None


_MESSAGES: dict[str, type[requests.ClientMessage]] = {
    "subscribe": requests.Subscribe,
    "unsubscribe": requests.Unsubscribe,
    "advertise": requests.Advertise,
    "unadvertise": requests.Unadvertise,
    "getParameters": requests.GetParameters,
    "setParameters": requests.SetParameters,
    "subscribeParameterUpdates": requests.SubscribeParameters,
    "unsubscribeParameterUpdates": requests.UnsubscribeParameters,
    "subscribeConnectionGraph": requests.SubscribeConnectionGraph,
    "unsubscribeConnectionGraph": requests.UnsubscribeConnectionGraph,
    "listRecordings": requests.ListRecordings,
    "startRecording": requests.StartRecording,
    "stopRecording": requests.StopRecording,
    "playRecording": requests.PlayRecording,
    "pausePlayback": requests.PausePlayback,
    "stopPlayback": requests.StopPlayback,
    "askTime": requests.AskTime,
    "fetchAsset": requests.FetchAsset,
}
