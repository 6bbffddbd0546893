"""Values as people type them: refused with our errors, or a message that can be sent and printed."""

from __future__ import annotations

from functools import cache

from rostether.errors import RostetherError
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore
from rostether.serde.yaml_form import parse_values
from rostether.serde.yaml_print import format_message

_TYPES = ("geometry_msgs/PoseStamped", "std_msgs/UInt8MultiArray", "sensor_msgs/Imu", "std_msgs/String")


def seeds() -> list[bytes]:
    """Return values in the forms of rostopic pub."""
    return [
        b"\x00{header: {stamp: now, frame_id: base}, pose: {position: {x: 1.0}}}",
        b"\x01data: [1, 2, 0xff]",
        b"\x02[auto, {x: .nan}, [0,0,0,0,0,0,0,0,0]]",
        b"\x03data: 'x'",
        b"\x03&a [*a, *a]",
    ]


@cache
def _store() -> TypeStore:
    return TypeStore(Registry())


def run(data: bytes) -> None:
    """Read as values of the type that the first byte chooses."""
    codec = _store().codec(_TYPES[data[0] % len(_TYPES)] if data else _TYPES[0])
    try:
        message = parse_values(codec, data[1:].decode("utf-8", "replace"), now=lambda: Time(1, 2))
    except RostetherError as error:
        assert "\n" not in str(error)
        return
    payload = codec.encode(message)
    assert codec.encode(codec.decode(payload)) == payload
    format_message(message)
