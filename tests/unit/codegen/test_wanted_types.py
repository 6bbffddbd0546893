from __future__ import annotations

from pathlib import Path

import pytest

from rostether.codegen.library_source import client_library
from rostether.codegen.type_index import TypeIndex
from rostether.codegen.wanted_types import WantedTypes, all_types, types_of_packages, types_of_sketch
from rostether.errors import UnknownTypeError
from rostether.msgdef.registry import Registry
from unit.codegen.hostile import write_definitions


def of_sketch(root: Path, text: str, registry: Registry | None = None) -> WantedTypes:
    sketch = root / "sketch.ino"
    sketch.write_text(text)
    index = TypeIndex(registry or Registry())
    return types_of_sketch(index, sketch, library_sources=client_library() / "src")


def test_all() -> None:
    names = all_types(TypeIndex(Registry())).names
    assert {"std_msgs/String", "std_srvs/SetBool", "tf/tfMessage"} <= names
    assert "std_srvs/SetBoolRequest" not in names


def test_a_package_brings_the_types_of_its_fields() -> None:
    names = types_of_packages(TypeIndex(Registry()), ["tf"]).names
    assert {"tf/tfMessage", "tf/FrameGraph", "geometry_msgs/TransformStamped", "std_msgs/Header"} <= names
    assert "std_msgs/String" not in names


def test_an_unknown_package_names_a_similar_one() -> None:
    with pytest.raises(
        UnknownTypeError, match=r"no package 'sensor_msg' is known; did you mean sensor_msgs\?"
    ):
        types_of_packages(TypeIndex(Registry()), ["sensor_msg"])


def test_a_sketch_gets_its_includes_and_the_types_of_their_fields(tmp_path: Path) -> None:
    names = of_sketch(tmp_path, "#include <nav_msgs/Odometry.h>\n#include <std_srvs/SetBool.h>\n").names
    assert {"nav_msgs/Odometry", "std_srvs/SetBool", "geometry_msgs/Vector3", "std_msgs/Header"} <= names
    assert len(names) < 20


def test_includes_of_the_librarys_headers_are_added(tmp_path: Path) -> None:
    plain = of_sketch(tmp_path, "#include <ros.h>\n").names
    with_tf = of_sketch(tmp_path, "#include <tf/transform_broadcaster.h>\n").names
    assert {"tf/tfMessage", "geometry_msgs/Transform"} <= with_tf - plain


def test_the_parts_of_actions_and_halves_of_services(tmp_path: Path) -> None:
    files = {
        "pkg/action/Go.action": "float32 x\n---\n---\nfloat32 y\n",
        "pkg/srv/Ask.srv": "string q\n---\nstring a\n",
        "pkg/msg/Log.msg": "AskRequest[] asked\n",
    }
    registry = Registry([write_definitions(tmp_path, files)])
    names = of_sketch(tmp_path, "#include <pkg/GoAction.h>\n#include <pkg/Log.h>\n", registry).names
    assert {"pkg/GoAction", "pkg/GoGoal", "pkg/Ask", "actionlib_msgs/GoalID"} <= names


@pytest.mark.parametrize(
    ("header", "reason"),
    [
        ("std_msgs/Strng", "package 'std_msgs' has no message 'Strng'; did you mean std_msgs/String?"),
        ("my_robot_msgs/Wheels", "no package 'my_robot_msgs' is known for my_robot_msgs/Wheels; "),
    ],
)
def test_an_unknown_message_is_reported_with_its_line(header: str, reason: str, tmp_path: Path) -> None:
    wanted = of_sketch(tmp_path, f"#include <ros.h>\n#include <{header}.h>\n")
    assert not wanted.doubtful
    assert len(wanted.missing) == 1
    assert wanted.missing[0].startswith(f"{tmp_path}/sketch.ino:2: {reason}")
    assert "--msg-path" in wanted.missing[0]


def test_headers_of_other_libraries_are_ignored(tmp_path: Path) -> None:
    text = "".join(
        f"#include <{header}>\n"
        for header in (
            "avr/io.h",
            "util/delay.h",
            "Servo.h",
            "Adafruit_GFX/Adafruit_GFX.h",
            "a/b/C.h",
            "x/C.hpp",
        )
    )
    wanted = of_sketch(tmp_path, text)
    assert (wanted.missing, wanted.doubtful) == ([], [])
    wanted = of_sketch(tmp_path, "#include <my_robot/Wheels.h>\n")
    assert wanted.missing == []
    assert "if <my_robot/Wheels.h> is a message: no package 'my_robot'" in wanted.doubtful[0]


def test_a_broken_part_is_left_to_the_generator(tmp_path: Path) -> None:
    registry = Registry([write_definitions(tmp_path, {"pkg/msg/A.msg": "B b\n", "pkg/msg/B.msg": "what\n"})])
    assert "pkg/A" in types_of_packages(TypeIndex(registry), ["pkg"]).names
