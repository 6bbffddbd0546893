"""Converts messages from the JSON of Foxglove's panels, for clients that do not serialize.

Times and durations are `{sec, nsec}` as in Foxglove's own messages, or use the field names of ROS 1 or ROS 2;
uint8[] is base64 or a list. Missing fields are zero.
"""

from __future__ import annotations

import base64
import binascii
import json
from typing import Any

from rostether.errors import RemoteProtocolError, SerializationError
from rostether.gateways.large_json import check_few_values, parse_json
from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.plain_form import base64_text, plain_value
from rostether.serde.type_tree import Array, Node, Stamp, Struct
from rostether.serde.values import Message

_SECONDS = ("sec", "secs")
_NANOSECONDS = ("nsec", "nsecs", "nanosec")


def decode_json(codec: Codec, data: bytes) -> dict[str, Any]:
    """Return the argument of `Codec.encode`. Raises SerializationError."""
    text = data.decode("utf-8", "replace") or "{}"
    try:
        check_few_values(text)
        value = parse_json(text)
    except RemoteProtocolError as error:
        raise SerializationError(f"{error}; send {codec.type_name} in another encoding") from None
    except (ValueError, RecursionError) as error:
        raise SerializationError(f"the message for {codec.type_name} is not JSON: {error}") from None
    if not isinstance(value, dict):
        raise SerializationError(f"the message for {codec.type_name} must be a JSON object")
    return _fields(codec.tree, value)


def encode_json(message: Message) -> bytes:
    """Return a message as JSON."""
    return json.dumps(_plain(message), separators=(",", ":")).encode()


def _fields(tree: Struct, value: dict[str, Any]) -> dict[str, Any]:
    nodes = {member.name: member.node for member in tree.members}
    return {name: _given(nodes[name], each) if name in nodes else each for name, each in value.items()}


def _given(node: Node, value: Any) -> Any:
    if isinstance(node, Struct) and isinstance(value, dict):
        return _fields(node, value)
    if isinstance(node, Stamp) and isinstance(value, dict):
        return _stamp(value)
    if isinstance(node, Array):
        if node.is_bytes and isinstance(value, str):
            try:
                return base64.b64decode(value, validate=True)
            except (binascii.Error, ValueError):
                return value
        if isinstance(value, list):
            return [_given(node.element, each) for each in value]
    return value


def _stamp(value: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, each in value.items():
        known = "secs" if name in _SECONDS else "nsecs" if name in _NANOSECONDS else name
        found[known] = each
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, Message):
        return {name: _plain(getattr(value, name)) for name, _ in value._fields}
    if isinstance(value, Time | Duration):
        return {"sec": value.secs, "nsec": value.nsecs}
    if isinstance(value, bytes):
        return base64_text(value)
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return plain_value(value)
