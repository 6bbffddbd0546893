from __future__ import annotations

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.md5sum import digest, message_md5_text, message_md5sum, service_md5sum
from rostether.msgdef.parse_msg import parse_message
from rostether.msgdef.parse_srv import parse_service
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import MessageSpec

# The md5sums that existing boards announce (from generated headers of the established library).
WELL_KNOWN = {
    "std_msgs/String": "992ce8a1687cec8c8bd883ec73ca41d1",
    "std_msgs/Empty": "d41d8cd98f00b204e9800998ecf8427e",
    "std_msgs/Header": "2176decaecbce78abc3b96ef049fabed",
    "sensor_msgs/Range": "c005c34273dc426c67a020a87bc24148",
    "sensor_msgs/Imu": "6a62c6daae103f4ff57a132d6f95cec2",
    "geometry_msgs/Twist": "9f195f881246fdfa2798d1d3eebca84a",
    "nav_msgs/Odometry": "cd5e73d190d741a2f92e81eda573aca7",
    "tf/tfMessage": "94810edda583a504dfda3829e70d7eec",
    "tf2_msgs/TFMessage": "94810edda583a504dfda3829e70d7eec",
    "rosgraph_msgs/Log": "acffd30cd6b6de30f120938c17c593fb",
    "rosgraph_msgs/Clock": "a9c97c1d230cfc112e270351a944ee47",
    "rosserial_msgs/TopicInfo": "0ad51f88fc44892f8c10684077646005",
    "rosserial_msgs/Log": "11abd731c25933261cd6183bd12d6295",
    "rosserial_arduino/Adc": "6d7853a614e2e821319068311f2af25b",
    "rosserial_arduino/TestRequest": "39e92f1778057359c64c7b8a7d7b19de",
    "rosserial_arduino/TestResponse": "0825d95fdfa2c8f4bbb4e9c74bccd3fd",
    "rosserial_msgs/RequestParamResponse": "9f0e98bda65981986ddf53afa7a40e49",
    "rosserial_msgs/RequestMessageInfoResponse": "fe452186a069bed40f09b8628fe5eac8",
    "rosserial_msgs/RequestServiceInfoResponse": "c3d6dd25b909596479fbbc6559fa6874",
    "turtlebot3_msgs/SensorState": "7250c1dc0b61c4190e78f528f599285f",
    "turtlebot3_msgs/Sound": "e1f8c7f8a9a61383b5734fbdeca2f99a",
    "turtlebot3_msgs/VersionInfo": "43e0361461af2970a33107409403ef3c",
}
WELL_KNOWN_SERVICES = {
    "std_srvs/Empty": "d41d8cd98f00b204e9800998ecf8427e",
    "std_srvs/SetBool": "09fb03525b03e7ea1fd3992bafd87e16",
    "std_srvs/Trigger": "937c9679a518e3a18d831e57125ea522",
    "roscpp/GetLoggers": "32e97e85527d4678a8f9279894bb64b0",
    "roscpp/SetLoggerLevel": "51da076440d78ca1684d36c868df61ea",
}


def nothing(name: str) -> MessageSpec:
    raise AssertionError(name)


def md5_text(text: str) -> str:
    return message_md5_text(parse_message(text, package="p", name="N"), nothing)


@pytest.mark.parametrize("name", sorted(WELL_KNOWN))
def test_well_known_messages(name: str) -> None:
    assert Registry().message_type(name).md5sum == WELL_KNOWN[name]


@pytest.mark.parametrize("name", sorted(WELL_KNOWN_SERVICES))
def test_well_known_services(name: str) -> None:
    assert Registry().service_type(name).md5sum == WELL_KNOWN_SERVICES[name]


def test_constants_come_first_and_as_written() -> None:
    text = "int8 a # x\nfloat32   B =  1e-3 # y\nint8[05] c\nint8 D=05\nstring E=\n"
    assert md5_text(text) == "float32 B=1e-3\nint8 D=05\nstring E=\nint8 a\nint8[05] c"


def test_comments_and_blanks_do_not_count() -> None:
    assert md5_text("int8 a\nint8 b") == md5_text("\n # x\n  int8    a #y\r\n\nint8\tb\n\n")


def test_messages_and_their_arrays_count_by_their_md5sum() -> None:
    inner = parse_message("int8 x", package="p", name="Inner")
    sum_of_inner = message_md5sum(inner, nothing)
    for declared in ("Inner", "p/Inner", "Inner[]", "Inner[3]"):
        outer = parse_message(f"{declared} y", package="p", name="Outer")
        assert message_md5_text(outer, lambda _: inner) == f"{sum_of_inner} y"


def test_a_service_is_the_sum_of_both_texts() -> None:
    both = parse_service("int8 a\n---\nint8 b", package="p", name="S")
    # There is nothing between request and response, not even a line end.
    assert service_md5sum(both, nothing) == digest("int8 aint8 b")


def test_a_cycle_is_an_error_not_an_endless_loop() -> None:
    def lookup(name: str) -> MessageSpec:
        return parse_message("A a", package="p", name="A")

    with pytest.raises(DefinitionError, match="cannot contain itself"):
        message_md5sum(lookup("p/A"), lookup)
