"""The support of types, by their ROS 1 definition or ROS 2 name, with and without a ROS 2 definition."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import DefinitionError, TypeMismatchError, UnknownTypeError
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.interface import MessageType, ServiceType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.types.type_support import Ros2Types, native_message
from rostether.serde.store import TypeStore
from unit.serde.cdr.pairs import own_fields

IMU_HASH = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
HEAD = b"\0\1\0\0"


@pytest.fixture(scope="module")
def types() -> Ros2Types:
    return Ros2Types(Registry(), Ros2Definitions())


def learned(name: str, text: str) -> MessageType:
    """Return a type as in a connection header; no folder has it."""
    registry = Registry()
    registry.add_full_text(name, text)
    return registry.message_type(name)


def test_a_message_that_both_ros_versions_have(types: Ros2Types) -> None:
    imu = types.registry.message_type("sensor_msgs/Imu")
    support = types.message(imu)
    assert (support.name, support.type_hash) == ("sensor_msgs/msg/Imu", IMU_HASH)
    assert support.ros1_type == imu
    assert types.message(imu) is support
    payload = bytes(16 + 296)
    assert support.converter.from_cdr(support.converter.to_cdr(payload)) == payload


def test_a_service_that_both_ros_versions_have(types: Ros2Types) -> None:
    set_bool = types.registry.service_type("std_srvs/SetBool")
    support = types.service(set_bool)
    assert support.name == "std_srvs/srv/SetBool"
    assert support.type_hash.startswith("RIHS01_")
    assert support.ros1_type == set_bool
    assert types.service(set_bool) is support
    assert support.request.to_cdr(b"\1") == HEAD + b"\1"
    response = support.response.to_cdr(b"\1\2\0\0\0ok")
    assert response == HEAD + b"\1\0\0\0\3\0\0\0ok\0"
    assert support.response.from_cdr(response) == b"\1\2\0\0\0ok"


def test_every_bundled_ros1_type_can_be_converted(types: Ros2Types) -> None:
    registry = types.registry
    for name in registry.messages():
        assert types.message(registry.message_type(name)).type_hash.startswith("RIHS01_"), name
    for name in registry.services():
        assert types.service(registry.service_type(name)).type_hash.startswith("RIHS01_"), name


def test_every_bundled_ros2_type_can_be_converted(types: Ros2Types) -> None:
    for name in types.definitions.names(Kind.MESSAGE):
        assert types.by_name(name).name == name
        assert native_message(types.definitions.message(name), types.definitions).type_hash
    for name in types.definitions.names(Kind.SERVICE):
        assert types.service_by_name(name).name == name
        assert types.native_service(name).md5sum


def test_a_message_that_only_a_connection_header_defines(types: Ros2Types) -> None:
    text = (
        "time stamp\nstd_msgs/Header header\nmy_robot/Wheel[] wheels\nfloat32 maxSpeed\n"
        + "=" * 80
        + "\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
        + "=" * 80
        + "\nMSG: my_robot/Wheel\nuint8 number\nfloat64 speed\n"
    )
    support = types.message(learned("my_robot/Drive", text))
    assert support.name == "my_robot/msg/Drive"
    payload = b"12345678" + b"\0\0\0\0" + b"abcdefgh" + b"\1\0\0\0m" + b"\1\0\0\0" + b"\7ABCDEFGH" + b"wxyz"
    cdr = support.converter.to_cdr(payload)
    assert cdr[4:] == (
        b"12345678" + b"abcdefgh" + b"\2\0\0\0m\0\0\0" + b"\1\0\0\0" + b"\7\0\0\0" + b"ABCDEFGH" + b"wxyz"
    )  # fmt: skip
    assert support.converter.from_cdr(cdr) == payload


def test_a_types_own_definition_has_priority(types: Ros2Types) -> None:
    changed = learned("my_robot/State", "uint8 a\n")
    other = learned("my_robot/State", "uint8 a\nuint8 b\n")
    assert types.message(changed).converter.to_cdr(b"\1") == HEAD + b"\1"
    assert types.message(other).converter.to_cdr(b"\1\2") == HEAD + b"\1\2"


def test_a_service_that_only_a_connection_header_defines(types: Ros2Types) -> None:
    request = learned("my_robot/MoveRequest", "float64 distance\nduration limit\n")
    nothing = MessageType("my_robot/MoveResponse", "d41d8cd98f00b204e9800998ecf8427e", "")
    support = types.service(ServiceType("my_robot/Move", "0" * 32, request, nothing))
    assert support.name == "my_robot/srv/Move"
    assert support.type_hash.startswith("RIHS01_")
    assert support.request.to_cdr(b"12345678abcdefgh") == HEAD + b"12345678abcdefgh"
    assert support.response.to_cdr(b"") == HEAD + b"\0"
    both = ServiceType(
        "my_robot/Stop", "1" * 32, *(_nothing(f"my_robot/Stop{h}") for h in ("Request", "Response"))
    )
    assert types.service(both).request.from_cdr(HEAD + b"\0") == b""


def _nothing(name: str) -> MessageType:
    return MessageType(name, "d41d8cd98f00b204e9800998ecf8427e", "")


def test_a_ros2_definition_on_this_machine_has_priority(tmp_path: Path) -> None:
    folder = tmp_path / "my_robot" / "msg"
    folder.mkdir(parents=True)
    (tmp_path / "my_robot" / "package.xml").write_text(
        '<package format="3"><name>my_robot</name><version>1.0.0</version>'
        "<description>d</description><maintainer email='a@b.c'>m</maintainer><license>l</license>"
        "<buildtool_depend>ament_cmake</buildtool_depend>"
        "<export><build_type>ament_cmake</build_type></export></package>"
    )
    (folder / "State.msg").write_text("uint8 mode 3\nfloat32 speed\n")
    (folder / "Other.msg").write_text("float32 velocity\n")
    types = Ros2Types(Registry(), Ros2Definitions([tmp_path]))
    support = types.message(learned("my_robot/State", "float32 speed\n"))
    assert own_fields(support.converter)[1] == ("mode",)
    assert support.converter.to_cdr(b"abcd") == HEAD + b"\3\0\0\0abcd"
    with pytest.raises(TypeMismatchError, match="only ROS 1 has 'speed' and only ROS 2 has 'velocity'"):
        types.message(learned("my_robot/Other", "float32 speed\n"))
    # Subscribers always have the native form.
    assert types.by_name("my_robot/msg/Other").ros1_type.definition.strip() == "float32 velocity"


def test_types_are_found_by_ros2_names(types: Ros2Types) -> None:
    assert types.by_name("sensor_msgs/msg/Imu").ros1_type == types.registry.message_type("sensor_msgs/Imu")
    assert types.by_name("rcl_interfaces/msg/Log").ros1_type.name == "rosgraph_msgs/Log"
    assert types.by_name("builtin_interfaces/msg/Time").ros1_type.name == "std_msgs/Time"
    assert types.by_name("tf2_msgs/msg/TFMessage").ros1_type.name == "tf2_msgs/TFMessage"
    assert types.by_name("std_srvs/srv/SetBool_Request").ros1_type.name == "std_srvs/SetBoolRequest"
    event = types.by_name("rcl_interfaces/msg/ParameterEvent")
    assert event.ros1_type.name == "rcl_interfaces/ParameterEvent"
    assert event is types.by_name("rcl_interfaces/msg/ParameterEvent")
    set_bool = types.service_by_name("std_srvs/srv/SetBool")
    assert set_bool.ros1_type == types.registry.service_type("std_srvs/SetBool")
    parameters = types.service_by_name("rcl_interfaces/srv/GetParameters")
    assert parameters.ros1_type.request.name == "rcl_interfaces/GetParametersRequest"


def test_native_types_drop_and_add_nothing(types: Ros2Types) -> None:
    for name in types.definitions.names(Kind.MESSAGE):
        native = native_message(types.definitions.message(name), types.definitions).ros1_type
        learned_store = TypeStore(Registry(bundled=False))
        learned_store.registry.add_full_text(native.name, native.definition)
        assert learned_store.registry.message_type(native.name).md5sum == native.md5sum, name
        if name not in ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"):
            converter = types.message(native).converter
            assert own_fields(converter) == ((), ()), name


def test_a_native_service_is_supported_like_others(types: Ros2Types) -> None:
    native = types.native_service("rcl_interfaces/srv/GetParameters")
    support = types.service(native)
    assert support.name == "rcl_interfaces/srv/GetParameters"
    assert support.type_hash == types.service_by_name("rcl_interfaces/srv/GetParameters").type_hash


def test_unknown_types_are_reported(types: Ros2Types) -> None:
    with pytest.raises(UnknownTypeError, match="nowhere"):
        types.by_name("nowhere/msg/Thing")
    for ask_service in (types.service_by_name, types.native_service):
        with pytest.raises(UnknownTypeError, match="nowhere"):
            ask_service("nowhere/srv/Thing")
    with pytest.raises(DefinitionError):
        types.message(MessageType("nowhere/Thing", "0" * 32))
