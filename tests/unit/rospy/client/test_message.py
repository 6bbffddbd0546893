from __future__ import annotations

import copy
import io
from pathlib import Path
from typing import Any

import pytest

from rostether.msgdef.registry import Registry
from rostether.rospy.client.exceptions import ROSException
from rostether.rospy.client.message import (
    AnyMsg,
    DeserializationError,
    Message,
    SerializationError,
    message_bytes,
    read_message,
)
from rostether.rospy.client.message_types import MessageTypes, message_type_of, service_type_of
from rostether.rospy.client.stamps import Time


@pytest.fixture(scope="module")
def types() -> MessageTypes:
    return MessageTypes(Registry())


def made(types: MessageTypes, name: str) -> Any:
    """Return a message class as untyped programs see it."""
    return types.message_class(name)


def test_fields_by_position_or_name(types: MessageTypes) -> None:
    point = made(types, "geometry_msgs/Point")
    assert point(1, 2, 3) == point(x=1, y=2, z=3)
    assert point().z == 0.0
    with pytest.raises(TypeError, match="Invalid number"):
        point(1, 2)
    with pytest.raises(TypeError, match="not both"):
        point(1, 2, z=3)
    with pytest.raises(AttributeError, match="w is not an attribute of Point"):
        point(w=1)
    with pytest.raises(AttributeError):
        point().w = 1


def test_messages_do_not_share_zero_values(types: MessageTypes) -> None:
    header = made(types, "std_msgs/Header")
    header().stamp.secs = 7
    assert header().stamp == Time()
    state = made(types, "sensor_msgs/JointState")
    state().name.append("a")
    assert state().name == []


def test_round_trip_gives_tuples_of_numbers(types: MessageTypes) -> None:
    state = made(types, "sensor_msgs/JointState")
    sent = state(name=["a"], position=[1, 2.5])
    sent.header.stamp = Time(3, 4)
    found: Any = read_message(state, message_bytes(sent))
    assert found == sent
    assert found.position == (1.0, 2.5)
    assert isinstance(found.header.stamp, Time)


def test_introspection(types: MessageTypes) -> None:
    state = made(types, "sensor_msgs/JointState")
    assert state.__slots__ == ["header", "name", "position", "velocity", "effort"]
    assert state._slot_types[0] == "std_msgs/Header"
    assert state._has_header
    assert state._md5sum == "3066dcd76a6cfaef579bd0f34173e9fd"
    assert (state.__module__, state.__name__) == ("sensor_msgs.msg", "JointState")
    assert message_type_of(state).definition == state._full_text


def test_misfits_are_reported(types: MessageTypes) -> None:
    text = made(types, "std_msgs/String")
    with pytest.raises(SerializationError, match="data"):
        text(5).serialize(io.BytesIO())
    with pytest.raises(DeserializationError):
        text().deserialize(b"\xff")


def test_bytes_that_are_not_text_are_replaced(types: MessageTypes) -> None:
    text = made(types, "std_msgs/String")
    assert text().deserialize(b"\x02\0\0\0a\xff").data == "a\ufffd"


def test_any_message_keeps_its_bytes() -> None:
    message: Any = AnyMsg().deserialize(b"abc")
    assert message_bytes(message) == b"abc"
    with pytest.raises(ROSException):
        message_bytes(AnyMsg())
    with pytest.raises(ROSException):
        AnyMsg(1)


def test_overridden_deserialize_is_called(types: MessageTypes) -> None:
    text: Any = types.message_class("std_msgs/String")

    class Loud(text):  # type: ignore[misc]
        __slots__ = ()

        def deserialize(self, str: bytes) -> Message:  # noqa: A002
            found: Any = super().deserialize(str)
            found.data = found.data.upper()
            return self

    found: Any = read_message(Loud, message_bytes(text("quiet")))
    assert found.data == "QUIET"


def test_services(types: MessageTypes) -> None:
    service: Any = types.service_class("std_srvs/SetBool")
    assert service._request_class(True).data is True
    assert service._response_class.__module__ == "std_srvs.srv"
    assert service_type_of(service).md5sum == "09fb03525b03e7ea1fd3992bafd87e16"


def test_prints_as_yaml(types: MessageTypes) -> None:
    pose = made(types, "geometry_msgs/PoseStamped")()
    pose.header.frame_id = "map"
    assert str(pose).splitlines()[:5] == [
        "header: ",
        "  seq: 0",
        "  stamp: ",
        "    secs: 0",
        "    nsecs:         0",
    ]


def test_names_that_are_keywords_end_with_an_underscore(tmp_path: Path) -> None:
    package = tmp_path / "mail"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>mail</name></package>")
    (package / "msg" / "Letter.msg").write_text("int8 pass=3\nstring from\nfloat64 self\nint8 to\n")
    letter = made(MessageTypes(Registry(package_path=[tmp_path])), "mail/Letter")
    sent = letter(from_="karl", to=2)
    sent.self_ = 0.5
    assert letter.__slots__ == ["from_", "self_", "to"]
    assert letter.pass_ == 3
    assert str(sent) == 'from_: "karl"\nself_: 0.5\nto: 2'
    received = read_message(letter, message_bytes(sent))
    assert (received.from_, received.self_, received.to) == ("karl", 0.5, 2)
    assert received == sent == letter("karl", 0.5, 2) == copy.deepcopy(sent)
