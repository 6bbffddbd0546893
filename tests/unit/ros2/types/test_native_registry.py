from __future__ import annotations

from pathlib import Path

import pytest

from loop_watch import FolderWatch
from rostether.errors import UnknownTypeError
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.msgdef.search_waiting import wait_for_definitions
from rostether.ros2.types.native_registry import NativeRegistry, short_name
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.store import TypeStore

REGISTRY = NativeRegistry(Ros2Definitions(), Registry())


def test_short_names() -> None:
    assert short_name("std_msgs/msg/String") == short_name("std_msgs/String") == "std_msgs/String"
    assert short_name("std_srvs/srv/SetBool_Request") == "std_srvs/SetBoolRequest"
    assert REGISTRY.message_type("std_msgs/msg/String") is REGISTRY.message_type("std_msgs/String")


def test_messages_are_as_in_ros2() -> None:
    header = REGISTRY.message("std_msgs/Header")
    assert [field.name for field in header.fields] == ["stamp", "frame_id"]
    store = TypeStore(REGISTRY)
    message = store.codec("sensor_msgs/Imu").message_class()
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (0, 0)


def test_services() -> None:
    service = REGISTRY.service_type("std_srvs/srv/SetBool")
    assert (service.name, service.request.name) == ("std_srvs/SetBool", "std_srvs/SetBoolRequest")
    assert [field.name for field in REGISTRY.message("std_srvs/SetBoolResponse").fields] == [
        "success",
        "message",
    ]
    assert "std_srvs/srv/SetBool" in REGISTRY.services("std_srvs")


def test_a_graph_converts_them() -> None:
    types = NativeTypes(REGISTRY)
    support = types.message(REGISTRY.message_type("sensor_msgs/Imu"))
    assert support.name == "sensor_msgs/msg/Imu"
    payload = TypeStore(REGISTRY).codec("sensor_msgs/Imu").encode({"header": {"frame_id": "a"}})
    assert support.converter.from_cdr(support.converter.to_cdr(payload)) == payload
    assert types.by_name("sensor_msgs/msg/Imu").ros1_type.md5sum == support.ros1_type.md5sum


def test_a_type_that_only_ros1_defines(tmp_path: Path) -> None:
    folder = tmp_path / "own_msgs"
    (folder / "msg").mkdir(parents=True)
    (folder / "srv").mkdir()
    (folder / "package.xml").write_text(
        "<package><name>own_msgs</name><version>1.0.0</version><description>x</description>"
        "<buildtool_depend>catkin</buildtool_depend></package>"
    )
    (folder / "msg" / "Reading.msg").write_text("Header header\ntime taken\nfloat32 value\n")
    (folder / "srv" / "Take.srv").write_text("bool now\n---\nReading reading\n")
    registry = NativeRegistry(Ros2Definitions([tmp_path]), Registry([tmp_path]))
    reading = registry.message("own_msgs/msg/Reading")
    assert [str(field.type) for field in reading.fields] == [
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "float32",
    ]
    assert [field.name for field in registry.message("own_msgs/TakeRequest").fields] == ["now"]
    assert registry.service_type("own_msgs/srv/Take").response.name == "own_msgs/TakeResponse"


def test_packages_of_ros2_near_the_current_folder_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "ws/src/my_msgs/msg"
    folder.mkdir(parents=True)
    (folder.parent / "package.xml").write_text(
        "<package><name>my_msgs</name><export><build_type>ament_cmake</build_type></export></package>"
    )
    (folder / "Foo.msg").write_text("string<=5 short\n")
    monkeypatch.chdir(tmp_path / "ws")
    registry = NativeRegistry.from_environment(environ={})
    assert registry.ros2_message("my_msgs/msg/Foo").fields[0].type.string_bound == 5
    # Folders farther up are not searched for ROS 2, and cause no error of ROS 1.
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UnknownTypeError, match="no ROS 2 package 'my_msgs' is known"):
        NativeRegistry.from_environment(environ={}).ros2_message("my_msgs/msg/Foo")


def test_tools_and_boards_have_the_same_hash_of_a_users_type(tmp_path: Path) -> None:
    (tmp_path / "own_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "own_msgs" / "srv").mkdir()
    (tmp_path / "own_msgs" / "msg" / "Inner.msg").write_text("byte a\nchar b\nfloat64[3] D\nint8 BIG=5\n")
    (tmp_path / "own_msgs" / "msg" / "Outer.msg").write_text(
        "Header header\nInner[] inners\nduration howLong\nstring text\nuint8[] data\n"
    )
    (tmp_path / "own_msgs" / "srv" / "Take.srv").write_text("time when\n---\nOuter outer\n")
    ros1, definitions = Registry([tmp_path]), Ros2Definitions([tmp_path])
    native = NativeRegistry(definitions, ros1)
    boards, tools = Ros2Types(ros1, definitions), NativeTypes(native)
    for name in ("own_msgs/Inner", "own_msgs/Outer"):
        theirs = boards.message(ros1.message_type(name))
        ours = tools.message(native.message_type(name))
        assert (ours.name, ours.type_hash) == (theirs.name, theirs.type_hash)
        assert tools.by_name(ours.name).type_hash == theirs.type_hash
    service = tools.service(native.service_type("own_msgs/Take"))
    assert service.type_hash == boards.service(ros1.service_type("own_msgs/Take")).type_hash
    assert tools.service_by_name("own_msgs/srv/Take").type_hash == service.type_hash


def test_errors_about_unknown_types_have_a_hint() -> None:
    with pytest.raises(UnknownTypeError, match="std_msgs"):
        REGISTRY.message("std_msgs/msg/Strin")
    with pytest.raises(UnknownTypeError):
        REGISTRY.service("std_srvs/srv/SetBol")


def installed(folder: Path) -> Path:
    messages = folder / "share" / "my_msgs" / "msg"
    messages.mkdir(parents=True)
    (messages / "Mine.msg").write_text("int32 x\n")
    return folder


async def test_folders_are_not_searched_on_the_event_loop(tmp_path: Path) -> None:
    registry = NativeRegistry(Ros2Definitions(prefixes=[installed(tmp_path)]), Registry())
    watch = FolderWatch()
    await wait_for_definitions(registry, lambda: registry.message_type("my_msgs/Mine"))
    assert registry.message("my_msgs/Mine").fields[0].name == "x"
    assert [each for each in watch.listed if str(tmp_path) in each] == []


async def test_types_are_searched_in_both_ros_versions(tmp_path: Path) -> None:
    types = Ros2Types(Registry(), Ros2Definitions(prefixes=[installed(tmp_path)]))
    watch = FolderWatch()
    await types.searched()
    assert types.definitions.message("my_msgs/msg/Mine").full_name == "my_msgs/msg/Mine"
    assert not types.definitions.has("my_msgs/msg/None")
    assert [each for each in watch.listed if str(tmp_path) in each] == []
