"""ROS messages in rosbridge's JSON, in both directions.

As in rosbridge, uint8[] and char[] are base64. Times and durations are `{"secs": ..., "nsecs": ...}`, on a
ROS 2 graph `{"sec": ..., "nanosec": ...}`. NaN and infinities, which JSON does not support, become null.
Bytes of a string that are not UTF-8 become U+FFFD. Input may use the field names of ROS 1 or ROS 2.
"""

from __future__ import annotations

import json
import math
from binascii import b2a_base64
from collections.abc import Mapping
from typing import Any

from rostether.gateways.rosbridge.form_source import (
    CompiledForms,
    Leaves,
    NotFiniteError,
    Style,
    compile_text,
    compile_values,
)
from rostether.gateways.rosbridge.values_in import message_payload
from rostether.rostime import Time
from rostether.serde.codec import Codec

_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


class JsonForm:
    """Converts messages of all types to JSON values and back; `style` chooses the field names."""

    def __init__(self, style: Style = Style.ROS1) -> None:
        leaves = Leaves(style, _base64)
        self._readers = CompiledForms(compile_values, leaves)
        self._writers = CompiledForms(compile_text, leaves)

    def text(self, codec: Codec, payload: bytes) -> str:
        """Return a payload as JSON text, the same as from `write_json` but faster.

        Raises SerializationError.
        """
        message = codec.decode(payload)
        try:
            return self._writers.of(codec)(message)
        except NotFiniteError:
            return write_json(self.to_json(codec, payload))

    def to_json(self, codec: Codec, payload: bytes) -> dict[str, Any]:
        """Return a payload as values for `write_json`. Raises SerializationError."""
        return self._readers.of(codec)(codec.decode(payload))

    def from_json(self, codec: Codec, value: object, now: Time) -> bytes:
        """Return the payload of a JSON value.

        Missing fields are zero. A missing stamp of a header, and a time "now", become `now`. Raises
        SerializationError with the name of the field that does not fit.
        """
        return message_payload(codec, value, now)


class JsonText(str):
    """A JSON text, which `write_json` must not encode again."""

    __slots__ = ()


def write_json(value: object) -> str:
    """Return values of `to_json`, and dicts and lists of them, as JSON; NaN and infinities become null."""
    try:
        return _encode(value)
    except ValueError:
        return _encode(_finite(value))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def _base64(value: bytes) -> str:
    return b2a_base64(value, newline=False).decode("ascii")
