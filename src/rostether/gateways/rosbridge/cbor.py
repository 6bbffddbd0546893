"""ROS messages in CBOR, as rosbridge sends them to subscribers that request `cbor` or `cbor-raw`.

Arrays of numbers are RFC 8746's typed arrays in little-endian order. uint8[] and char[] are byte strings.
Times are as in JSON. `cbor-raw` contains the serialization of the message, and the time of receipt.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

import cbor2

from rostether.gateways.rosbridge.form_source import CompiledForms, Leaves, Style, compile_values
from rostether.rostime import Time
from rostether.serde.codec import Codec

# RFC 8746 tags by `struct` format; uint8[] is a byte string, and booleans have no tag.
_TYPED_ARRAY_TAGS: Final = {
    "H": 69,
    "I": 70,
    "Q": 71,
    "b": 72,
    "h": 77,
    "i": 78,
    "q": 79,
    "f": 85,
    "d": 86,
}


class CborForm:
    """Messages of all types in CBOR; `style` is the form of times."""

    def __init__(self, style: Style = Style.ROS1) -> None:
        self._readers = CompiledForms(compile_values, Leaves(style, bytes, _typed_array))

    def publish(self, topic: str, codec: Codec, payload: bytes) -> bytes:
        """Return the `publish` frame of a payload. Raises SerializationError."""
        message = codec.decode(payload)
        return cbor2.dumps({"op": "publish", "topic": topic, "msg": self._readers.of(codec)(message)})


def publish_raw(topic: str, payload: bytes, now: Time) -> bytes:
    """Return the `publish` frame with a raw payload; `now` is the time of receipt."""
    message = {"secs": now.secs, "nsecs": now.nsecs, "bytes": payload}
    return cbor2.dumps({"op": "publish", "topic": topic, "msg": message})


def _typed_array(code: str) -> Callable[[list[Any]], cbor2.CBORTag]:
    tag = _TYPED_ARRAY_TAGS[code]

    def pack(values: list[Any]) -> cbor2.CBORTag:
        return cbor2.CBORTag(tag, struct.pack(f"<{len(values)}{code}", *values))

    return pack
