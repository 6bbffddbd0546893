from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError, DefinitionError, UnknownTypeError
from rostether.msgdef import definition_files
from rostether.msgdef import registry as registry_module
from rostether.msgdef.full_text import SEPARATOR
from rostether.msgdef.registry import Registry

PACKAGES = {
    "actionlib",
    "actionlib_tutorials",
    "arduino_control",
    "sensing_platform",
    "sensors",
    "move_base_msgs",
    "actionlib_msgs",
    "diagnostic_msgs",
    "geometry_msgs",
    "nav_msgs",
    "roscpp",
    "roscpp_tutorials",
    "rosapi",
    "rosgraph_msgs",
    "rosserial_arduino",
    "rosserial_msgs",
    "rospy_tutorials",
    "sensor_msgs",
    "shape_msgs",
    "std_msgs",
    "std_srvs",
    "stereo_msgs",
    "tf",
    "tf2_msgs",
    "tf2_web_republisher",
    "topic_tools",
    "trajectory_msgs",
    "turtlebot3_msgs",
    "visualization_msgs",
}


def write(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


def test_the_bundled_packages() -> None:
    assert set(Registry().packages()) == PACKAGES
    assert Registry(bundled=False).packages() == []


def test_every_bundled_type_has_md5sum_and_full_text() -> None:
    registry = Registry()
    assert len(registry.messages()) > 140
    assert len(registry.services()) >= 19
    for name in registry.messages():
        message_type = registry.message_type(name)
        assert message_type.name == name
        assert len(message_type.md5sum) == 32
        assert message_type.definition.startswith(registry.message(name).text)
    for name in registry.services():
        service_type = registry.service_type(name)
        assert service_type.request.name == f"{name}Request"
        assert len(service_type.md5sum) == 32


def test_names_are_listed_by_package_sorted() -> None:
    registry = Registry()
    assert registry.messages("rosserial_msgs") == ["rosserial_msgs/Log", "rosserial_msgs/TopicInfo"]
    assert registry.services("tf") == ["tf/FrameGraph"]
    assert registry.messages("unknown") == []
    assert registry.messages() == sorted(registry.messages())


def test_an_action_gives_seven_messages() -> None:
    names = [name for name in Registry().messages("tf2_msgs") if "LookupTransform" in name]
    assert len(names) == 7
    feedback = Registry().message("tf2_msgs/LookupTransformActionFeedback")
    assert feedback.fields[2].type.base == "tf2_msgs/LookupTransformFeedback"


def test_halves_of_services_are_messages() -> None:
    registry = Registry()
    assert registry.message("std_srvs/SetBoolRequest") == registry.service("std_srvs/SetBool").request
    assert (
        registry.message_type("std_srvs/SetBoolResponse")
        == registry.service_type("std_srvs/SetBool").response
    )


def test_answers_are_cached() -> None:
    registry = Registry()
    assert registry.message("std_msgs/String") is registry.message("std_msgs/String")
    assert registry.service("std_srvs/Empty") is registry.service("std_srvs/Empty")
    assert registry.message_type("std_msgs/String") is registry.message_type("std_msgs/String")
    assert registry.service_type("std_srvs/Empty") is registry.service_type("std_srvs/Empty")


def test_definitions_are_read_on_demand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[Path] = []

    def reading(file: Path) -> str:
        read.append(file)
        return definition_files.read_definition(file)

    monkeypatch.setattr(registry_module, "read_definition", reading)
    write(tmp_path / "my_msgs" / "Broken.msg", "oops")
    registry = Registry([tmp_path])
    assert registry.messages("my_msgs") == ["my_msgs/Broken"]
    assert read == []
    registry.message_type("geometry_msgs/Twist")
    assert [file.name for file in read] == ["Twist.msg", "Vector3.msg"]


def test_the_users_definition_wins_over_the_bundled_one(tmp_path: Path) -> None:
    write(tmp_path / "sensor_msgs" / "msg" / "Range.msg", "float32 range # mine\n")
    registry = Registry([tmp_path])
    assert registry.message("sensor_msgs/Range").text == "float32 range # mine\n"
    assert registry.message("sensor_msgs/Imu").fields[0].name == "header"
    assert "sensor_msgs/Imu" in registry.messages("sensor_msgs")


def test_msg_path_wins_over_ros_package_path(tmp_path: Path) -> None:
    for root in ("path", "package_path"):
        write(tmp_path / root / "my_msgs" / "package.xml", "<package><name>my_msgs</name></package>")
        write(tmp_path / root / "my_msgs" / "msg" / "Foo.msg", f"int8 {root}\n")
    write(tmp_path / "package_path" / "my_msgs" / "msg" / "Bar.msg", "int8 x\n")
    environ = {"ROS_PACKAGE_PATH": f"{tmp_path / 'package_path'}:/nowhere"}
    registry = Registry.from_environment([tmp_path / "path"], environ)
    assert registry.message("my_msgs/Foo").fields[0].name == "path"
    assert registry.message("my_msgs/Bar").fields[0].name == "x"
    assert Registry.from_environment([], environ).message("my_msgs/Foo").fields[0].name == "package_path"
    with pytest.raises(UnknownTypeError):
        Registry.from_environment([], {}).message("my_msgs/Foo")


def test_a_msg_path_that_is_not_a_folder_is_an_error_at_once(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"--msg-path .*missing: no such folder"):
        Registry.from_environment([tmp_path / "missing"], {})
    with pytest.raises(ConfigError, match="no such folder"):
        Registry.from_environment([write(tmp_path / "Foo.msg", "")], {})


def test_a_broken_definition_affects_only_its_own_type(tmp_path: Path) -> None:
    write(tmp_path / "my_msgs" / "Broken.msg", "int8 a\nint8\n")
    write(tmp_path / "my_msgs" / "Good.msg", "int8 a\n")
    write(tmp_path / "my_msgs" / "User.msg", "Broken b\n")
    write(tmp_path / "my_msgs" / "Half.srv", "oops\n---\n")
    write(tmp_path / "my_msgs" / "Act.action", "---\n")
    registry = Registry([tmp_path])
    assert registry.message_type("my_msgs/Good").md5sum
    for name in ("my_msgs/Broken", "my_msgs/User"):
        with pytest.raises(DefinitionError, match=r"Broken\.msg:2:1:"):
            registry.message_type(name)
    assert registry.message("my_msgs/User").fields[0].name == "b"
    with pytest.raises(DefinitionError, match=r"Half\.srv:1:1:"):
        registry.message("my_msgs/HalfRequest")
    with pytest.raises(DefinitionError, match=r"Act\.action: "):
        registry.message("my_msgs/ActGoal")


def test_users_actions_and_services_are_found(tmp_path: Path) -> None:
    write(tmp_path / "my_msgs" / "action" / "Dock.action", "int8 a\n---\nint8 b\n---\nint8 c\n")
    write(tmp_path / "my_msgs" / "srv" / "Park.srv", "int8 a\n---\nHeader h\n")
    registry = Registry([tmp_path])
    assert len(registry.messages("my_msgs")) == 7
    assert registry.message_type("my_msgs/DockAction").definition.count(SEPARATOR) == 9
    assert registry.services("my_msgs") == ["my_msgs/Park"]
    assert "stamp" in registry.service_type("my_msgs/Park").response.definition


def test_a_message_file_wins_over_a_service_half_of_its_name(tmp_path: Path) -> None:
    write(tmp_path / "my_msgs" / "ParkRequest.msg", "int8 own\n")
    write(tmp_path / "my_msgs" / "Park.srv", "int8 half\n---\n")
    assert Registry([tmp_path]).message("my_msgs/ParkRequest").fields[0].name == "own"


@pytest.mark.parametrize(
    "name",
    ["", "String", "a/b/c", "/String", "std_msgs/", "std_msgs/1", "../etc/passwd", "p/é", "a" * 999 + "/B"],
)
def test_an_invalid_type_name_is_an_error_with_an_example(name: str) -> None:
    with pytest.raises(UnknownTypeError, match="package/Name, such as std_msgs/String") as raised:
        Registry().message(name)
    assert "\n" not in str(raised.value)
    with pytest.raises(UnknownTypeError, match="package/Name, such as std_srvs/SetBool"):
        Registry().service(name)


def test_an_unknown_nested_type_is_reported_with_its_field(tmp_path: Path) -> None:
    write(tmp_path / "my_msgs" / "Foo.msg", "other_msgs/Bar bar\n")
    with pytest.raises(UnknownTypeError, match=r"my_msgs/Foo, field 'bar': no package 'other_msgs' is known"):
        Registry([tmp_path]).message_type("my_msgs/Foo")


LEARNED = (
    f"Header header\nPart[] parts\n{SEPARATOR}\nMSG: std_msgs/Header\nuint32 seq\n{SEPARATOR}\n"
    "MSG: far/Part\nint8 x"
)


def test_a_type_is_learned_from_a_full_text() -> None:
    registry = Registry()
    registry.add_full_text("far/Thing", LEARNED)
    assert [str(field.type) for field in registry.message("far/Thing").fields] == [
        "std_msgs/Header",
        "far/Part[]",
    ]
    assert registry.message("far/Part").text == "int8 x"
    assert registry.messages("far") == ["far/Part", "far/Thing"]
    assert "far" in registry.packages()
    # Known types are unchanged.
    assert len(registry.message("std_msgs/Header").fields) == 3


def test_a_separate_registry_reads_a_full_text_exactly() -> None:
    registry = Registry(bundled=False)
    registry.add_full_text("far/Thing", LEARNED)
    assert registry.message_type("far/Thing").definition == LEARNED
    assert len(registry.message("std_msgs/Header").fields) == 1


def test_bundled_types_can_be_learned_back_with_the_same_md5sum() -> None:
    registry = Registry()
    for name in registry.messages():
        learned = Registry(bundled=False)
        learned.add_full_text(name, registry.message_type(name).definition)
        assert learned.message_type(name) == registry.message_type(name)


def test_an_invalid_full_text_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    registry = Registry(bundled=False)
    for name, definition in [
        ("far/Thing", "oops"),
        ("far/Thing", f"int8 a\n{SEPARATOR}\nMSG: nonsense\nint8 x"),
        ("nonsense", "int8 a"),
    ]:
        with pytest.raises(DefinitionError):
            registry.add_full_text(name, definition)
    assert registry.messages() == []
    monkeypatch.setattr(registry_module, "MAX_LEARNED_TYPES", 2)
    with pytest.raises(DefinitionError, match="more than 2 types"):
        registry.add_full_text("far/Thing", LEARNED)
    registry.add_full_text("far/One", "int8 a")
    registry.add_full_text("far/Two", "int8 a")
    registry.add_full_text("far/Two", "int8 a")
    with pytest.raises(DefinitionError, match="more than 2 types"):
        registry.add_full_text("far/Three", "int8 a")


@pytest.mark.parametrize("place", ["ws", "ws/src", "ws/src/std_srvs/launch"])
def test_a_package_of_the_workspace_replaces_the_bundled_one_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    package = tmp_path / "ws" / "src" / "std_srvs"
    write(package / "package.xml", "<package><name>std_srvs</name></package>")
    write(package / "srv" / "Trigger.srv", "int8 mine\n---\n")
    write(tmp_path / "ws" / "src" / "other" / "package.xml", "<package><name>std_msgs</name></package>")
    (package / "launch").mkdir()
    monkeypatch.chdir(tmp_path / place)
    registry = Registry.from_environment((), {})
    assert registry.service("std_srvs/Trigger").request.fields[0].name == "mine"
    assert registry.services("std_srvs") == ["std_srvs/Trigger"]
    with pytest.raises(UnknownTypeError, match=r"std_srvs has no srv/SetBool\.srv, and replaces the bundled"):
        registry.service("std_srvs/SetBool")
    # A package without definitions does not replace another package.
    assert registry.message("std_msgs/String").fields[0].name == "data"


def test_packages_around_the_current_folder_are_searched_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "home" / "ws" / "src"
    for package in ("my_msgs", "std_msgs"):
        write(source / package / "package.xml", f"<package><name>{package}</name></package>")
    write(source / "my_msgs" / "msg" / "Foo.msg", "int8 near\n")
    write(source / "my_msgs" / "srv" / "Bar.srv", "---\n")
    write(source / "std_msgs" / "msg" / "String.msg", "int8 not_this\n")
    write(tmp_path / "path" / "my_msgs" / "package.xml", "<package><name>my_msgs</name></package>")
    # Outside a workspace: the packages below the current folder.
    monkeypatch.chdir(tmp_path / "home")
    registry = Registry.from_environment((), {})
    assert registry.message("std_msgs/String").fields[0].name == "data"
    assert registry.message("my_msgs/Foo").fields[0].name == "near"
    assert registry.messages("my_msgs") == ["my_msgs/Foo"]
    assert registry.services("my_msgs") == ["my_msgs/Bar"]
    assert "my_msgs" in registry.packages()
    write(tmp_path / "path" / "my_msgs" / "msg" / "Foo.msg", "int8 on_path\n")
    on_path = Registry.from_environment((), {"ROS_PACKAGE_PATH": str(tmp_path / "path")})
    assert on_path.message("my_msgs/Foo").fields[0].name == "on_path"


def test_the_tutorials_types_are_those_of_ros() -> None:
    registry = Registry()
    for name in ("rospy_tutorials/AddTwoInts", "roscpp_tutorials/TwoInts"):
        assert registry.service_type(name).md5sum == "6a2e34150c00229791cc89ff309fff21"
    assert registry.message_type("rospy_tutorials/Floats").md5sum == "420cd38b6b071cd49f2970c3e2cee511"
    assert registry.message_type("rospy_tutorials/HeaderString").md5sum == "c99a9440709e4d4a9716d55b8270d5e7"
