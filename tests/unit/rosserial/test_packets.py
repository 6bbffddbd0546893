from __future__ import annotations

import struct

import pytest

from rostether.errors import LocalProtocolError
from rostether.rosserial.packets import (
    Log,
    LogLevel,
    ParameterRequest,
    ParameterResponse,
    TopicInfo,
    decode_time,
    encode_time,
)
from rostether.rostime import Time

CHATTER = TopicInfo(125, "chatter", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", 280)
CHATTER_BYTES = bytes.fromhex(
    "7d0007000000636861747465720f0000007374645f6d7367732f537472696e6720000000"
    "393932636538613136383763656338633862643838336563373363613431643118010000"
)


def test_topic_info_as_recorded() -> None:
    assert CHATTER.encode() == CHATTER_BYTES
    assert TopicInfo.decode(CHATTER_BYTES) == CHATTER


@pytest.mark.parametrize(
    "name", ["chatter", "/ultrasound", "~state", "arm/joint_1/angle", "/a", "x", "robot/1/cmd", "~/x"]
)
def test_names_that_devices_announce(name: str) -> None:
    info = TopicInfo(100, name, "std_msgs/Empty", "0" * 32, 512)
    assert TopicInfo.decode(info.encode()) == info


@pytest.mark.parametrize(
    "wrong",
    [
        {"topic_id": 99},
        {"topic_id": 7},
        {"topic_name": ""},
        {"topic_name": "/"},
        {"topic_name": "~"},
        {"topic_name": "a//b"},
        {"topic_name": "chat ter"},
        {"topic_name": "chat\x07"},
        {"topic_name": "1st"},
        {"topic_name": "blå"},
        {"topic_name": "chatter\n"},
        {"topic_name": "x" * 256},
        {"message_type": "String"},
        {"message_type": "std_msgs/"},
        {"message_type": "std_msgs/String/More"},
        {"message_type": "std_msgs String"},
        {"md5sum": "992ce8a1687cec8c8bd883ec73ca41d"},
        {"md5sum": "992ce8a1687cec8c8bd883ec73ca41dg"},
        {"md5sum": "992CE8A1687CEC8C8BD883EC73CA41D1"},
        {"buffer_size": -1},
        {"buffer_size": 1 << 24},
    ],
    ids=str,
)
def test_announcements_that_must_be_damage(wrong: dict[str, object]) -> None:
    fields = {name: getattr(CHATTER, name) for name in CHATTER.__struct_fields__}
    assert TopicInfo.decode(TopicInfo(**{**fields, **wrong}).encode()) is None


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"topic_name": "left-wheel"}, "have only letters, digits, _ and /; write left_wheel in the sketch"),
        ({"topic_name": "2 wheels//a"}, "write wheels/a in the sketch"),
        ({"topic_name": "---"}, "choose another in the sketch"),
        ({"message_type": "String"}, "package/Type; include the package, as in std_msgs/String, in the"),
        ({"message_type": "std_msgs/msg/String"}, "write std_msgs/String in the sketch"),
        ({"message_type": "std_msgs::String"}, "write std_msgs/String in the sketch"),
        ({"message_type": ""}, "package/Type; write one in the sketch"),
        ({"md5sum": "*"}, "md5sum '*' is not 32 digits"),
        ({"buffer_size": -5}, "buffer size is -5 bytes; choose 0 to 1048576"),
        ({"topic_id": 12}, "topic id is 12, but ids below 100 are reserved"),
    ],
    ids=str,
)
def test_the_error_names_what_to_change(wrong: dict[str, object], reason: str) -> None:
    fields = {name: getattr(CHATTER, name) for name in CHATTER.__struct_fields__}
    info = TopicInfo.read(TopicInfo(**{**fields, **wrong}).encode())
    assert info is not None
    fault = info.fault()
    assert fault is not None
    assert reason in fault
    assert "\n" not in fault


def test_a_name_that_is_not_utf_8_is_read_and_faulty() -> None:
    info = TopicInfo.read(CHATTER_BYTES.replace(b"chatter", b"t\xfcr_auf"))
    assert info is not None
    assert "write t_r_auf in the sketch" in (info.fault() or "")


def test_a_valid_announcement_has_no_fault() -> None:
    assert CHATTER.fault() is None


def test_announcement_of_another_length() -> None:
    assert TopicInfo.decode(b"") is None
    assert TopicInfo.decode(CHATTER_BYTES + b"\0") is None
    for size in range(len(CHATTER_BYTES)):
        assert TopicInfo.decode(CHATTER_BYTES[:size]) is None


def test_strings_that_claim_more_than_there_is() -> None:
    for claim in (70, 0xFFFF, 0xFFFFFFFF):
        assert TopicInfo.decode(CHATTER_BYTES[:2] + struct.pack("<I", claim) + CHATTER_BYTES[6:]) is None


def test_topic_info_that_does_not_fit_a_frame() -> None:
    with pytest.raises(LocalProtocolError, match="cannot announce"):
        TopicInfo(1 << 16, "a", "b/C", "0" * 32, 1).encode()


@pytest.mark.parametrize("level", LogLevel)
def test_log(level: LogLevel) -> None:
    assert Log.decode(Log(level, "Gurkensalat grün").encode()) == Log(level, "Gurkensalat grün")


def test_log_with_bytes_that_are_not_text() -> None:
    assert Log.decode(b"\x02\x02\0\0\0a\xff") == Log(LogLevel.WARN, "a\N{REPLACEMENT CHARACTER}")


@pytest.mark.parametrize("level", [5, 16, 255])
def test_log_of_an_unknown_level_is_as_grave_as_can_be(level: int) -> None:
    assert Log.decode(bytes([level]) + b"\x02\0\0\0hi") == Log(LogLevel.FATAL, "hi")


@pytest.mark.parametrize("payload", [b"", b"\x01", b"\x01\x02\0\0\0a", b"\x01\x01\0\0\0ab"])
def test_log_that_must_be_damage(payload: bytes) -> None:
    assert Log.decode(payload) is None


def test_parameter_request() -> None:
    assert ParameterRequest.decode(bytes.fromhex("050000007e72617465")) == ("~rate",)
    assert ParameterRequest.decode(ParameterRequest("my param").encode()) == ("my param",)


@pytest.mark.parametrize(
    "payload", [b"", b"\0\0\0\0", b"\x02\0\0\0a\n", b"\x02\0\0\0a", b"\x01\0\0\0ab", b"\x01\0\0\0\xff"]
)
def test_parameter_request_that_must_be_damage(payload: bytes) -> None:
    assert ParameterRequest.decode(payload) is None


def test_parameter_response() -> None:
    response = ParameterResponse((-1, 2**31 - 1), (2.5, float("-inf")), ("left arm", ""))
    assert ParameterResponse.decode(response.encode()) == response
    assert ParameterResponse((10,)).encode().hex() == "010000000a0000000000000000000000"
    assert ParameterResponse().encode() == bytes(12)


@pytest.mark.parametrize("response", [ParameterResponse((2**31,)), ParameterResponse((), (1e39,))])
def test_parameter_values_that_do_not_fit(response: ParameterResponse) -> None:
    with pytest.raises(LocalProtocolError, match="does not fit"):
        response.encode()


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        bytes(11),
        bytes(13),
        b"\xff" * 12,
        bytes(8) + b"\xff\xff\xff\xff",
        bytes(8) + b"\x01\0\0\0\x05\0\0\0abc",
    ],
)
def test_parameter_response_that_must_be_damage(payload: bytes) -> None:
    assert ParameterResponse.decode(payload) is None


def test_time() -> None:
    assert decode_time(encode_time(Time(1700000000, 999999999))) == Time(1700000000, 999999999)
    assert decode_time(encode_time(Time(2**32 + 5, 0))) == Time(5, 0)


@pytest.mark.parametrize("payload", [b"", bytes(7), bytes(9), struct.pack("<II", 1, 1_000_000_000)])
def test_time_that_must_be_damage(payload: bytes) -> None:
    assert decode_time(payload) is None
