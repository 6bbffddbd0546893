"""Values as users type them: refused with our errors, or a message that can be sent and printed."""

from __future__ import annotations

import random
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


def generate(source: random.Random) -> bytes:
    """Return fields in the forms of rostopic pub; sometimes too few, too many or of a wrong type."""
    index = source.randrange(len(_TYPES))
    text = source.choice(
        (
            f"{{header: {_header(source)}, pose: {{position: {_list(source, 3)}}}}}",
            f"{{header: {_header(source)}, orientation: {_list(source, 4)}}}",
            f"data: {_list(source, 4)}",
            f"{{layout: {{dim: [{_list(source, 3)}], data_offset: {_scalar(source)}}}, data: [1, 2]}}",
            f"[{_header(source)}, {_list(source, 4)}, {_list(source, 9)}]",
            f"data: {_scalar(source)}",
        )
    )
    return bytes([index]) + text.encode()


def _header(source: random.Random) -> str:
    return source.choice(
        ("auto", "{stamp: now}", f"{{stamp: {_list(source, 2)}}}", f"{{seq: {_scalar(source)}}}", "[]")
    )


def _list(source: random.Random, size: int) -> str:
    count = size + source.choice((0, 0, 0, 0, -1, 1))
    return f"[{', '.join(_scalar(source) for _ in range(count))}]"


def _scalar(source: random.Random) -> str:
    number = str(source.choice((0, 1, -1, 255, 256, 2**31, 2**32, 10**400)))
    return source.choice(
        (number, number, "1.5", "nan", "1e400", "'x'", "true", "", "{}", "2020-01-01", '"\\ud800"')
    )


@cache
def _store() -> TypeStore:
    return TypeStore(Registry())


def run(data: bytes) -> None:
    """Read the data as values of the type that the first byte selects."""
    codec = _store().codec(_TYPES[data[0] % len(_TYPES)] if data else _TYPES[0])
    try:
        message = parse_values(codec, data[1:].decode("utf-8", "replace"), now=lambda: Time(1, 2))
    except RostetherError as error:
        assert "\n" not in str(error)
        return
    payload = codec.encode(message)
    assert codec.encode(codec.decode(payload)) == payload
    format_message(message)
