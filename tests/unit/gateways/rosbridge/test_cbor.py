from __future__ import annotations

import struct
from typing import Any

import cbor2
import pytest

from rostether.gateways.rosbridge.cbor import CborForm, publish_raw
from rostether.gateways.rosbridge.form_source import Style
from rostether.msgdef.registry import Registry
from rostether.rostime import Time
from rostether.serde.store import TypeStore

STORE = TypeStore(Registry())


def sent(name: str, value: dict[str, Any], style: Style = Style.ROS1) -> Any:
    codec = STORE.codec(name)
    frame = cbor2.loads(CborForm(style).publish("/topic", codec, codec.encode(value)))
    assert (frame["op"], frame["topic"]) == ("publish", "/topic")
    return frame["msg"]


@pytest.mark.parametrize(
    ("name", "tag", "code"),
    [
        ("UInt16", 69, "H"),
        ("UInt32", 70, "I"),
        ("UInt64", 71, "Q"),
        ("Int8", 72, "b"),
        ("Int16", 77, "h"),
        ("Int32", 78, "i"),
        ("Int64", 79, "q"),
        ("Float32", 85, "f"),
        ("Float64", 86, "d"),
    ],
)
def test_arrays_of_numbers_are_typed_arrays(name: str, tag: int, code: str) -> None:
    data = sent(f"std_msgs/{name}MultiArray", {"data": [1, 2, 100]})["data"]
    assert (data.tag, struct.unpack(f"<3{code}", data.value)) == (tag, (1, 2, 100))


def test_bytes_times_and_texts() -> None:
    assert sent("std_msgs/UInt8MultiArray", {"data": b"\x00\xff"})["data"] == b"\x00\xff"
    assert sent("std_msgs/Header", {"stamp": Time(1, 2), "frame_id": "ü"}) == {
        "seq": 0,
        "stamp": {"secs": 1, "nsecs": 2},
        "frame_id": "ü",
    }
    assert sent("std_msgs/Time", {"data": Time(1, 2)}, Style.ROS2) == {"data": {"sec": 1, "nanosec": 2}}


def test_raw_is_the_payload_with_its_time() -> None:
    assert cbor2.loads(publish_raw("/topic", b"\x01\x02", Time(5, 6))) == {
        "op": "publish",
        "topic": "/topic",
        "msg": {"secs": 5, "nsecs": 6, "bytes": b"\x01\x02"},
    }
