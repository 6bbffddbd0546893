"""Converts the messages of Foxglove clients to ROS messages; slow conversions run in a thread.

In JSON, times and durations are `{sec, nsec}` as in Foxglove's own messages, or use the field names of ROS 1
or ROS 2; uint8[] is base64 or a list. Missing fields are zero.
"""

from __future__ import annotations

import asyncio
import base64
import json
import sys
from collections.abc import Callable
from typing import Any, Final

import msgspec

from rostether.errors import ConfigError, RemoteProtocolError, SerializationError
from rostether.gateways.client_json import check_few_values, parse_json
from rostether.gateways.foxglove.server_messages import JSON_ENCODING, ROS1_ENCODING
from rostether.rostime import Duration, Time
from rostether.serde.codec import Codec
from rostether.serde.plain_form import base64_text, plain_value
from rostether.serde.type_tree import Array, Node, Stamp, Struct
from rostether.serde.values import Message

# Longer messages may take longer than 10 ms. In JSON, each `{}` can be a message with default values.
MAX_QUICK_JSON_BYTES: Final = 1 << 10

# The check of each string in a list takes 0.3 µs, and an empty string has only 4 bytes.
_MAX_QUICK_ROS1_BYTES: Final = 32 << 10

# Types with more default values are slow in any JSON message.
_MANY_DEFAULTS: Final = 1000


class Encoder(msgspec.Struct, frozen=True):
    """Converts a client's message to a ROS message. `encode` raises SerializationError."""

    encode: Callable[[bytes], bytes]
    max_quick_bytes: int

    @classmethod
    def of(cls, encoding: str, codec: Codec, what: str = "messages") -> Encoder:
        """Return the encoder of messages in JSON, or in ROS 1's form, which are only checked.

        Raises ConfigError for another encoding, with a text about `what`.
        """
        if encoding == JSON_ENCODING:
            is_small = codec.tree.zero_elements <= _MANY_DEFAULTS
            return cls(
                lambda payload: codec.encode(decode_json(codec, payload)),
                MAX_QUICK_JSON_BYTES if is_small else 0,
            )
        if encoding != ROS1_ENCODING:
            raise ConfigError(f"{what} are {ROS1_ENCODING} or {JSON_ENCODING}, not {encoding[:40]!r}")
        layout = codec.layout

        def check(payload: bytes) -> bytes:
            if not layout.accepts(payload):
                raise SerializationError(layout.explain(payload))
            return payload

        return cls(check, _MAX_QUICK_ROS1_BYTES if layout.has_varying_elements else sys.maxsize)

    def is_slow(self, payload: bytes) -> bool:
        """Return whether a message may take longer than 10 ms."""
        return len(payload) > self.max_quick_bytes

    async def convert(self, payload: bytes) -> bytes:
        """Return the ROS message, without delaying other clients. Raises SerializationError."""
        if self.is_slow(payload):
            return await asyncio.to_thread(self.encode, payload)
        return self.encode(payload)


_STAMP_FIELDS = {"sec": "secs", "nsec": "nsecs", "nanosec": "nsecs"}


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
    return json.dumps(plain_value(message, base64_text, _stamp_fields), separators=(",", ":")).encode()


def _fields(tree: Struct, value: dict[str, Any]) -> dict[str, Any]:
    nodes = {member.name: member.node for member in tree.members}
    return {name: _given(nodes[name], each) if name in nodes else each for name, each in value.items()}


def _given(node: Node, value: Any) -> Any:
    if isinstance(node, Struct) and isinstance(value, dict):
        return _fields(node, value)
    if isinstance(node, Stamp) and isinstance(value, dict):
        return {_STAMP_FIELDS.get(name, name): each for name, each in value.items()}
    if isinstance(node, Array):
        if node.is_bytes and isinstance(value, str):
            try:
                return base64.b64decode(value, validate=True)
            except ValueError:
                return value
        if isinstance(value, list):
            return [_given(node.element, each) for each in value]
    return value


def _stamp_fields(stamp: Time | Duration) -> dict[str, int]:
    return {"sec": stamp.secs, "nsec": stamp.nsecs}
