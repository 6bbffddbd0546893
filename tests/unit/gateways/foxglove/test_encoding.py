from __future__ import annotations

import json

import pytest

from rostether.errors import SerializationError
from rostether.gateways.foxglove.encoding import decode_json, encode_json
from rostether.msgdef.registry import Registry
from rostether.rostime import Duration, Time
from rostether.serde.store import TypeStore

STORE = TypeStore(Registry())


@pytest.mark.parametrize(
    "stamp", ['{"sec": 1, "nsec": 2}', '{"secs": 1, "nsecs": 2}', '{"sec": 1, "nanosec": 2}']
)
def test_times_may_have_either_ros_names(stamp: str) -> None:
    codec = STORE.codec("std_msgs/Header")
    message = codec.conform(decode_json(codec, f'{{"stamp": {stamp}, "frame_id": "map"}}'.encode()))
    assert (message.stamp, message.frame_id, message.seq) == (Time(1, 2), "map", 0)


def test_bytes_may_be_base64_or_numbers_and_structs_in_lists_are_followed() -> None:
    codec = STORE.codec("sensor_msgs/Image")
    for data in ('"AP8="', "[0, 255]"):
        assert codec.conform(decode_json(codec, f'{{"data": {data}}}'.encode())).data == b"\0\xff"
    codec = STORE.codec("tf2_msgs/TFMessage")
    text = b'{"transforms": [{"header": {"stamp": {"sec": 3, "nsec": 4}}}]}'
    assert codec.conform(decode_json(codec, text)).transforms[0].header.stamp == Time(3, 4)


def test_messages_are_written() -> None:
    codec = STORE.codec("std_msgs/Duration")
    assert json.loads(encode_json(codec.conform({"data": Duration(5, 6)}))) == {"data": {"sec": 5, "nsec": 6}}
    image = STORE.codec("sensor_msgs/CompressedImage").conform({"data": b"\0\xff"})
    assert json.loads(encode_json(image))["data"] == "AP8="
    nan = STORE.codec("std_msgs/Float64").conform({"data": float("nan")})
    assert json.loads(encode_json(nan)) == {"data": "NaN"}


@pytest.mark.parametrize("text", [b"{", b"[]", b"1", b"\xff", b"[" * 100_000])
def test_what_is_not_a_message_is_reported(text: bytes) -> None:
    with pytest.raises(SerializationError, match="std_msgs/String"):
        decode_json(STORE.codec("std_msgs/String"), text)


@pytest.mark.parametrize("text", [b'{"data": 1}', b'{"other": ""}', b'{"data": null}'])
def test_what_does_not_fit_names_the_field(text: bytes) -> None:
    codec = STORE.codec("std_msgs/String")
    with pytest.raises(SerializationError, match=r"data|other"):
        codec.encode(decode_json(codec, text))
