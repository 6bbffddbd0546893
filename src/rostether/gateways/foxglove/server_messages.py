"""The messages of a Foxglove server: JSON objects with an `op`, and binary messages with an opcode.

Source: the Foxglove WebSocket protocol, https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md.
Integers in binary messages are little endian.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any

import msgspec

from rostether.mechanisms.text import fold_line
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.rostime import NS_PER_S

# The subprotocols of the current Foxglove and of older clients; the messages are the same.
SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")

ROS1_ENCODING = "ros1"
JSON_ENCODING = "json"
_SCHEMA_ENCODING = "ros1msg"

_TIME = struct.Struct("<BQ")
_SERVICE_RESPONSE = struct.Struct("<BIII")
_ASSET_RESPONSE = struct.Struct("<BIBI")
_TIME_OPCODE, _SERVICE_RESPONSE_OPCODE, _ASSET_RESPONSE_OPCODE = 0x02, 0x03, 0x04
_ASSET_FOUND, _ASSET_FAILED = 0, 1

# The capabilities for which clients send encoded messages.
_ENCODED = frozenset({"clientPublish", "services"})

# A status may contain names from clients; users do not read longer lines.
_MAX_TEXT_CHARACTERS = 2000


class StatusLevel(IntEnum):
    """The severity of a status message."""

    INFO = 0
    WARNING = 1
    ERROR = 2


class Channel(msgspec.Struct, frozen=True):
    """A topic as clients see it; a topic whose type changes gets another id."""

    id: int
    topic: str
    type: MessageType


class AdvertisedService(msgspec.Struct, frozen=True):
    """A service as clients see it."""

    id: int
    name: str
    type: ServiceType


def server_info(
    *, name: str, capabilities: Sequence[str], session_id: str, metadata: Mapping[str, str]
) -> str:
    """Return the first message of every connection."""
    message: dict[str, Any] = {
        "op": "serverInfo",
        "name": name,
        "capabilities": list(capabilities),
        "metadata": dict(metadata),
        "sessionId": session_id,
    }
    if not _ENCODED.isdisjoint(capabilities):
        message["supportedEncodings"] = [ROS1_ENCODING, JSON_ENCODING]
    return _json(message)


def status(level: StatusLevel, text: str, status_id: str | None = None) -> str:
    """Return a line for users; a line with an id replaces the previous one and can be removed."""
    message: dict[str, Any] = {"op": "status", "level": int(level), "message": _one_line(text)}
    if status_id is not None:
        message["id"] = status_id
    return _json(message)


def remove_status(status_ids: Iterable[str]) -> str:
    """Return the message that removes lines for users."""
    return _json({"op": "removeStatus", "statusIds": list(status_ids)})


def advertise(channels: Iterable[Channel]) -> str:
    """Return the message that offers channels."""
    described = [{"id": channel.id, "topic": channel.topic, **_schema(channel.type)} for channel in channels]
    return _json({"op": "advertise", "channels": described})


def unadvertise(channel_ids: Iterable[int]) -> str:
    """Return the message that ends channels and the subscriptions to them."""
    return _json({"op": "unadvertise", "channelIds": list(channel_ids)})


def advertise_services(services: Iterable[AdvertisedService]) -> str:
    """Return the message that offers services."""
    described = [
        {
            "id": service.id,
            "name": service.name,
            "type": service.type.name,
            "request": _schema(service.type.request),
            "response": _schema(service.type.response),
        }
        for service in services
    ]
    return _json({"op": "advertiseServices", "services": described})


def unadvertise_services(service_ids: Iterable[int]) -> str:
    """Return the message that ends services."""
    return _json({"op": "unadvertiseServices", "serviceIds": list(service_ids)})


def parameter_values(parameters: Sequence[Mapping[str, Any]], request_id: str | None = None) -> str:
    """Return parameters in their JSON form, see `parameters.py`; the message has the id of the request."""
    message: dict[str, Any] = {"op": "parameterValues", "parameters": list(parameters)}
    if request_id is not None:
        message["id"] = request_id
    return _json(message)


def connection_graph_update(changes: Mapping[str, Any]) -> str:
    """Return the changes of the graph, see `connection_graph.py`."""
    return _json({"op": "connectionGraphUpdate", **changes})


def drive(channel_id: int, state: str, driver: str) -> str:
    """Return who drives the topic of a client's channel; an op of this gateway.

    `state` is free, driving (this client) or taken (another client), and `driver` a display name.
    """
    return _json({"op": "drive", "channelId": channel_id, "state": state, "driver": driver})


def recordings(state: Mapping[str, Any]) -> str:
    """Return the recordings, see `recordings.py`; an op of this gateway."""
    return _json({"op": "recordings", **state})


def time_answer(request_id: int, time_ns: int) -> str:
    """Return the response to a time request; an op of this gateway."""
    sec, nsec = divmod(time_ns, NS_PER_S)
    return _json({"op": "timeAnswer", "id": request_id, "sec": sec, "nsec": nsec})


def service_failure(service_id: int, call_id: int, text: str) -> str:
    """Return why a call failed."""
    return _json(
        {"op": "serviceCallFailure", "serviceId": service_id, "callId": call_id, "message": _one_line(text)}
    )


def service_response(service_id: int, call_id: int, encoding: str, payload: bytes) -> bytes:
    """Return the response to a call."""
    name = encoding.encode()
    header = _SERVICE_RESPONSE.pack(_SERVICE_RESPONSE_OPCODE, service_id, call_id, len(name))
    return header + name + payload


def time(time_ns: int) -> bytes:
    """Return the message with the server's time."""
    return _TIME.pack(_TIME_OPCODE, time_ns)


def asset_head(request_id: int) -> bytes:
    """Return the header before the bytes of a requested file."""
    return _ASSET_RESPONSE.pack(_ASSET_RESPONSE_OPCODE, request_id, _ASSET_FOUND, 0)


def asset_failure(request_id: int, text: str) -> bytes:
    """Return why a file is not available."""
    reason = _one_line(text).encode("utf-8", "replace")
    return _ASSET_RESPONSE.pack(_ASSET_RESPONSE_OPCODE, request_id, _ASSET_FAILED, len(reason)) + reason


def _one_line(text: str) -> str:
    # Names from clients may contain line breaks, and have any length.
    return fold_line(text[:_MAX_TEXT_CHARACTERS])


def _schema(message: MessageType) -> dict[str, str]:
    return {
        "encoding": ROS1_ENCODING,
        "schemaName": message.name,
        "schemaEncoding": _SCHEMA_ENCODING,
        "schema": message.definition,
    }


def _json(message: Mapping[str, Any]) -> str:
    return json.dumps(message, separators=(",", ":"), allow_nan=False)
