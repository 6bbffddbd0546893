"""One store serves layouts and codecs by name, each made once."""

from __future__ import annotations

import pytest

from rostether.errors import UnknownTypeError
from rostether.msgdef.registry import Registry
from rostether.serde.store import TypeStore


def test_each_is_made_once() -> None:
    registry = Registry()
    store = TypeStore(registry)
    assert store.registry is registry
    assert store.layout("std_msgs/String") is store.layout("std_msgs/String")
    assert store.codec("std_msgs/String") is store.codec("std_msgs/String")
    assert store.codec("std_msgs/String").layout is store.layout("std_msgs/String")


def test_nested_messages_are_of_the_nested_types_class() -> None:
    store = TypeStore(Registry())
    twist = store.codec("geometry_msgs/Twist").message_class()
    assert type(twist.linear) is store.codec("geometry_msgs/Vector3").message_class


def test_request_and_response_of_a_service() -> None:
    store = TypeStore(Registry())
    assert store.layout("std_srvs/SetBoolRequest").fixed_size_bytes == 1
    assert store.codec("std_srvs/SetBoolResponse").message_class(success=True).message == ""


def test_unknown_type_is_not_kept() -> None:
    registry = Registry()
    store = TypeStore(registry)
    with pytest.raises(UnknownTypeError):
        store.codec("my_robot_msgs/Thing")
    registry.add_full_text("my_robot_msgs/Thing", "int32 x\n")
    assert store.codec("my_robot_msgs/Thing").encode({"x": 1}) == b"\1\0\0\0"


def test_the_codecs_of_a_service() -> None:
    request, response = TypeStore(Registry()).service_codecs("std_srvs/SetBool")
    assert (request.type_name, response.type_name) == ("std_srvs/SetBoolRequest", "std_srvs/SetBoolResponse")
