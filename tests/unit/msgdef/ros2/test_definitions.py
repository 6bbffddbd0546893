"""Sources of ROS 2 definitions, and their order."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.errors import ConfigError, DefinitionError, UnknownTypeError
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.ros2.definition_files import BUNDLED_FOLDER
from rostether.msgdef.ros2.definitions import Ros2Definitions

PACKAGE_XML = "<package format='3'><name>{name}</name><version>1.0.0</version>{rest}</package>"
ROS2 = "<buildtool_depend>ament_cmake</buildtool_depend><export><build_type>ament_cmake</build_type></export>"
ROS1 = "<buildtool_depend>catkin</buildtool_depend>"


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def package(folder: Path, rest: str = ROS2, **texts: str) -> None:
    write(folder / "package.xml", PACKAGE_XML.format(name=folder.name, rest=rest))
    for name, text in texts.items():
        kind = "srv" if "---" in text else "msg"
        write(folder / kind / f"{name}.{kind}", text)


def names(definitions: Ros2Definitions, name: str) -> list[str]:
    return [field.name for field in definitions.message(name).fields]


def test_every_bundled_text_can_be_read_with_nested_types() -> None:
    for distro in ("humble", "iron", "jazzy", "kilted", "lyrical", "rolling"):
        definitions = Ros2Definitions(distro=distro)
        assert len(definitions.names(Kind.MESSAGE)) > 150
        for name in definitions.names(Kind.MESSAGE):
            assert definitions.message(name).full_name == name
            dependencies(definitions.message(name), definitions.message)
        for name in definitions.names(Kind.SERVICE):
            service = definitions.service(name)
            assert definitions.message(f"{name}_Request") == service.request
            assert definitions.message(f"{name}_Response") == service.response
            for half in (service.request, service.response):
                dependencies(half, definitions.message)
                assert definitions.has(half.full_name)


def test_bundled_texts_are_fields_and_constants_only() -> None:
    for file in BUNDLED_FOLDER.rglob("*.*"):
        assert "#" not in file.read_text(), file


def test_distributions_have_their_own_definitions() -> None:
    assert "variance" not in names(Ros2Definitions(distro="humble"), "sensor_msgs/msg/Range")
    for distro in ("iron", "jazzy", "kilted", "lyrical", "one_to_come"):
        assert "variance" in names(Ros2Definitions(distro=distro), "sensor_msgs/msg/Range")
    for distro, first in (("humble", "timestamp"), ("kilted", "timestamp"), ("rolling", "stamp")):
        assert names(Ros2Definitions(distro=distro), "lifecycle_msgs/msg/TransitionEvent")[0] == first
    level = Ros2Definitions(distro="humble").message("rcl_interfaces/msg/Log").constants[0]
    assert level.type == "byte"


def test_lists_packages_messages_and_services() -> None:
    definitions = Ros2Definitions()
    assert {"std_msgs", "tf2_msgs", "service_msgs"} <= set(definitions.packages())
    assert "std_msgs/msg/String" in definitions.names(Kind.MESSAGE, "std_msgs")
    assert definitions.names(Kind.SERVICE, "std_srvs") == [
        "std_srvs/srv/Empty",
        "std_srvs/srv/SetBool",
        "std_srvs/srv/Trigger",
    ]
    assert definitions.names(Kind.MESSAGE, "std_srvs") == []
    assert definitions.names(Kind.MESSAGE, "no_such") == []


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("std_msgs/String", "write package/msg/Name"),
        ("std_msgs/msg/../String", "not a ROS 2 type name"),
        ("std_msgs/msg/Strin", "did you mean std_msgs/msg/String?"),
        ("std_msg/msg/String", "did you mean std_msgs?"),
        ("nobody_msgs/msg/Foo", "no ROS 2 package 'nobody_msgs'"),
        ("std_srvs/srv/SetBool", "is a service, not a message"),
        ("std_srvs/srv/SetBol_Request", "did you mean std_srvs/srv/SetBool?"),
        ("x" * 9999, "not a ROS 2 type name"),
    ],
)
def test_explains_an_unknown_message(name: str, says: str) -> None:
    definitions = Ros2Definitions()
    with pytest.raises(UnknownTypeError) as error:
        definitions.message(name)
    assert says in str(error.value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 300


def test_explains_an_unknown_service() -> None:
    definitions = Ros2Definitions()
    with pytest.raises(UnknownTypeError, match="is a message, not a service"):
        definitions.service("std_msgs/msg/String")
    with pytest.raises(UnknownTypeError, match="write package/srv/Name"):
        definitions.service("std_srvs/SetBool")
    assert not definitions.has("std_srvs/srv/SetBol")
    assert not definitions.has("std_srvs/SetBool")
    assert definitions.has("std_srvs/srv/SetBool")


def test_bundled_can_be_omitted() -> None:
    definitions = Ros2Definitions(bundled=False)
    assert definitions.packages() == []
    assert not definitions.has("std_msgs/msg/String")


def test_reads_installed_packages(tmp_path: Path) -> None:
    # Merged below one prefix, and each below its own prefix, as colcon builds them.
    package(tmp_path / "ros/share/my_msgs", Foo="int8 first\n", Set="bool on\n---\n")
    package(tmp_path / "ws/your_msgs/share/your_msgs", Bar="my_msgs/Foo foo\n")
    package(tmp_path / "ws/your_msgs/share/std_msgs", String="string<=5 data\n")
    (tmp_path / "ros/share/rviz/icons").mkdir(parents=True)
    write(tmp_path / "ros/share/my_msgs/msg/Only.idl", "module my_msgs {};\n")
    environ = {
        "AMENT_PREFIX_PATH": f"{tmp_path}/ros:{tmp_path}/missing",
        "COLCON_PREFIX_PATH": f"{tmp_path}/ws",
    }
    definitions = Ros2Definitions.from_environment(environ=environ)
    assert definitions.message("your_msgs/msg/Bar").fields[0].type.base == "my_msgs/msg/Foo"
    assert definitions.message("std_msgs/msg/String").fields[0].type.string_bound == 5
    assert definitions.names(Kind.SERVICE, "my_msgs") == ["my_msgs/srv/Set"]
    assert "your_msgs" in definitions.packages()
    assert "rviz" not in definitions.packages()
    with pytest.raises(UnknownTypeError, match=r"installed as \.idl only"):
        definitions.message("my_msgs/msg/Only")


def test_reads_packages_of_ros_package_path(tmp_path: Path) -> None:
    package(tmp_path / "src/my_msgs", Foo="string<=5 short\n")
    package(tmp_path / "src/old_msgs", Bar="time stamp\n")
    (tmp_path / "src/old_msgs/package.xml").write_text(
        "<package><name>old_msgs</name><buildtool_depend>catkin</buildtool_depend></package>"
    )
    definitions = Ros2Definitions.from_environment(environ={"ROS_PACKAGE_PATH": str(tmp_path / "src")})
    assert definitions.message("my_msgs/msg/Foo").fields[0].type.string_bound == 5
    assert not definitions.has("old_msgs/msg/Bar")
    with pytest.raises(UnknownTypeError, match=rf"searched: {tmp_path}/src, "):
        definitions.message("my_msgs/msg/Missing")


def test_packages_from_pip_only_add_types(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(tmp_path / "share/std_msgs", String="string<=5 data\n")
    package(tmp_path / "share/pip_msgs", Foo="int8 a\n")
    (tmp_path / "share/ament_index").mkdir()
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    definitions = Ros2Definitions.from_environment(environ={})
    assert definitions.message("std_msgs/msg/String").fields[0].type.string_bound is None
    assert definitions.names(Kind.MESSAGE, "pip_msgs") == ["pip_msgs/msg/Foo"]
    assert "pip_msgs" in definitions.packages()
    assert names(definitions, "pip_msgs/msg/Foo") == ["a"]


def test_reads_the_distribution() -> None:
    for environ, distro in (
        ({}, "jazzy"),
        ({"ROS_DISTRO": "humble"}, "humble"),
        ({"ROS_DISTRO": "humble", "ROS_VERSION": "2"}, "humble"),
        ({"ROS_DISTRO": "noetic", "ROS_VERSION": "1"}, "jazzy"),
        ({"ROS_DISTRO": "noetic"}, "jazzy"),
    ):
        assert Ros2Definitions.from_environment(environ=environ).distro == distro


def test_a_folder_of_the_user_has_priority_and_must_exist(tmp_path: Path) -> None:
    package(tmp_path / "src/std_msgs", String="string<=7 data\n")
    definitions = Ros2Definitions.from_environment([tmp_path / "src"], environ={})
    assert definitions.message("std_msgs/msg/String").fields[0].type.string_bound == 7
    with pytest.raises(ConfigError, match="no such folder"):
        Ros2Definitions.from_environment([tmp_path / "nowhere"], environ={})


def test_distinguishes_ros2_definitions_from_ros1(tmp_path: Path) -> None:
    package(tmp_path / "new_msgs", Broken="time stamp\n", Good="std_msgs/Header header\n")
    package(tmp_path / "old_msgs", ROS1, Plain="int8 a\n")
    write(tmp_path / "loose_msgs/Both.msg", "int8 a\n")
    write(tmp_path / "loose_msgs/Old.msg", "Header header\nint8 a\n")
    write(tmp_path / "loose_msgs/Older.msg", "time frameId\n")
    write(tmp_path / "loose_msgs/New.msg", "string<=4 a\n")
    write(tmp_path / "own_msgs/msg/Header.msg", "int8 a\n")
    write(tmp_path / "own_msgs/msg/Uses.msg", "Header header\n")
    definitions = Ros2Definitions([tmp_path])
    assert definitions.names(Kind.MESSAGE, "loose_msgs") == ["loose_msgs/msg/Both", "loose_msgs/msg/New"]
    assert definitions.names(Kind.MESSAGE, "old_msgs") == []
    assert not definitions.has("old_msgs/msg/Plain")
    assert not definitions.has("loose_msgs/msg/Old")
    assert definitions.has("own_msgs/msg/Uses")
    assert names(definitions, "new_msgs/msg/Good") == ["header"]
    # The package declares that it is for ROS 2: its mistake is reported, not ignored.
    with pytest.raises(DefinitionError, match=r"Broken\.msg:1:1: 'time' is a type of ROS 1"):
        definitions.message("new_msgs/msg/Broken")


def test_nesting_is_bounded_too(tmp_path: Path) -> None:
    write(tmp_path / "x/Loop.msg", "Other[] other\n")
    write(tmp_path / "x/Other.msg", "Loop loop\n")
    write(tmp_path / "x/Missing.msg", "Nowhere there\n")
    write(tmp_path / "x/Huge.msg", "Big[4096] big\n")
    write(tmp_path / "x/Big.msg", "float64[4096] numbers\n")
    definitions = Ros2Definitions([tmp_path])
    for name, says in (
        ("Loop", "cannot contain itself: x/msg/Loop -> x/msg/Other -> x/msg/Loop"),
        ("Missing", "x/msg/Missing, field 'there': the ROS 2 package 'x' has no message 'Nowhere'"),
        ("Huge", "every message would have 16777216 values"),
    ):
        with pytest.raises(DefinitionError, match=says):
            dependencies(definitions.message(f"x/msg/{name}"), definitions.message)


def test_a_package_of_the_user_replaces_the_bundled_one_whole(tmp_path: Path) -> None:
    for kind in ("given", "install/share"):
        package = tmp_path / kind / "std_srvs"
        (package / "srv").mkdir(parents=True)
        (package / "package.xml").write_text(
            "<package><name>std_srvs</name><buildtool_depend>ament_cmake</buildtool_depend></package>"
        )
        (package / "srv" / "Trigger.srv").write_text("int8 mine\n---\n")
    for definitions in (
        Ros2Definitions([tmp_path / "given"]),
        Ros2Definitions(prefixes=[tmp_path / "install"]),
    ):
        assert definitions.names(Kind.SERVICE, "std_srvs") == ["std_srvs/srv/Trigger"]
        assert not definitions.has("std_srvs/srv/SetBool")
        assert definitions.has("std_msgs/msg/String")
