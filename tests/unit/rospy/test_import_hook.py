from __future__ import annotations

from pathlib import Path

import pytest

from unit.rospy.programs import printed

PACKAGE_XML = "<package><name>arm</name><version>1.0.0</version><description>d</description></package>"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "ws" / "src" / "arm"
    for path, text in {
        "package.xml": PACKAGE_XML,
        "msg/Angles.msg": "int16 LEFT=3\nHeader header\nint16[] angles\n",
        "srv/Move.srv": "string name\n---\nbool success\n",
        "src/arm/__init__.py": "VERSION = 4\n",
        "src/arm/geometry.py": "from arm.msg import Angles\ndef zero(): return Angles(angles=[0])\n",
        "src/arm_tools.py": "NAME = 'tools'\n",
        "setup.py": "",
    }.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return folder


async def test_definitions_and_modules_of_a_package(package: Path) -> None:
    script = """
import arm.geometry, arm_tools
from arm.msg import *
from arm.srv import Move, MoveRequest, MoveResponse
import arm.msg, arm.srv, std_msgs
print(arm.VERSION, arm.geometry.zero() == Angles(angles=[0]), Angles.LEFT, arm_tools.NAME)
print(arm.msg.__all__, arm.srv.__all__, Move._request_class is MoveRequest, 'Angles' in dir(arm.msg))
import pickle
print(pickle.loads(pickle.dumps(Angles(angles=(1, 2)))) == Angles(angles=[1, 2]))
"""
    lines = await printed(script, packages={"arm": package})
    assert lines == [
        "4 True 3 tools",
        "['Angles'] ['Move', 'MoveRequest', 'MoveResponse'] True True",
        "True",
    ]


async def test_packages_of_ros_package_path(package: Path) -> None:
    lines = await printed(
        "import arm.msg; print(arm.msg.Angles()._type)", environ={"ROS_PACKAGE_PATH": str(package.parent)}
    )
    assert lines == ["arm/Angles"]


async def test_messages_of_ros_2_with_the_same_names_are_not_used(tmp_path: Path) -> None:
    for path, text in {
        "std_msgs/__init__.py": "",
        "std_msgs/msg/__init__.py": "class String: pass\n",
    }.items():
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    lines = await printed(
        "from std_msgs.msg import String; print(String('x').data)", environ={"PYTHONPATH": str(tmp_path)}
    )
    assert lines == ["x"]


async def test_missing_names_are_reported(package: Path) -> None:
    script = """
for name in ("arm.msg:Nothing", "arm.nothing:x", "nothing.msg:x"):
    module, _, attribute = name.partition(":")
    try:
        exec(f"from {module} import {attribute}")
    except ImportError as error:
        print(type(error).__name__, error)
import arm.msg
try:
    arm.msg.Nothing
except AttributeError as error:
    print(error)
"""
    lines = await printed(script, packages={"arm": package})
    assert lines[0].startswith("ImportError cannot import name 'Nothing' from 'arm.msg'")
    assert lines[1].startswith("ModuleNotFoundError No module named 'arm.nothing'")
    assert lines[2].startswith("ModuleNotFoundError No module named 'nothing'")
    assert lines[3] == "module 'arm.msg' has no 'Nothing': package arm has no file Nothing.msg"


async def test_missing_modules_of_ros_name_the_next_step() -> None:
    script = """
for name in ("leg_msgs.msg", "cv_bridge"):
    try:
        __import__(name)
    except ModuleNotFoundError as error:
        print(error.name, error)
"""
    messages, bridge = await printed(script)
    assert messages.startswith(
        "leg_msgs No module named 'leg_msgs': put the package with its .msg files into"
    )
    assert bridge.startswith("cv_bridge No module named 'cv_bridge': rostether does not include it")


async def test_a_broken_definition_is_an_import_error(package: Path) -> None:
    (package / "msg" / "Broken.msg").write_text("int16 a b c\n")
    script = """
try:
    from arm.msg import Broken
except ImportError as error:
    print(error)
"""
    assert "Broken.msg" in (await printed(script, packages={"arm": package}))[0]


async def test_a_real_rospy_is_never_hidden(tmp_path: Path) -> None:
    (tmp_path / "rospy.py").write_text("REAL = True\n")
    script = "import sys, rospy; print(rospy.REAL, any('modules' in entry for entry in sys.path))"
    assert await printed(script, environ={"PYTHONPATH": str(tmp_path)}) == ["True False"]


async def test_another_sitecustomize_also_runs(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text("import builtins\nbuiltins.CUSTOM = 5\n")
    script = "import rospy; print(CUSTOM)"
    assert await printed(script, environ={"PYTHONPATH": str(tmp_path)}) == ["5"]


async def test_folders_of_packages(package: Path) -> None:
    script = """
import rospkg, roslib.packages
print(rospkg.RosPack().get_path("arm"), roslib.packages.get_pkg_dir("arm"), rospkg.RosPack().list())
try:
    rospkg.RosPack().get_path("leg")
except rospkg.ResourceNotFound as error:
    print("no", error)
"""
    lines = await printed(script, packages={"arm": package})
    assert lines == [f"{package} {package} ['arm']", "no leg"]


async def test_package_information(package: Path) -> None:
    (package.parent / "leg").mkdir()
    (package.parent / "leg" / "package.xml").write_text(
        "<package><name>leg</name><version>2</version><license>MIT</license><depend>arm</depend>"
        "<depend>std_msgs</depend></package>"
    )
    (package / "scripts").mkdir()
    (package / "scripts" / "move.py").touch(0o755)
    script = """
import roslib.packages, rospkg
pack = rospkg.RosPack()
print(pack.get_depends("leg"), pack.get_depends_on("arm"), pack.get_manifest("leg").depends)
print(pack.get_manifest("leg").version, rospkg.get_package_name(pack.get_path("arm") + "/msg"))
print(roslib.packages.find_node("arm", "move.py"), roslib.packages.find_node("arm", "Angles.msg"))
"""
    lines = await printed(script, environ={"ROS_PACKAGE_PATH": str(package.parent)})
    assert lines == [
        "['arm'] ['leg'] [arm, std_msgs]",
        "2 arm",
        f"['{package}/scripts/move.py'] []",
    ]


async def test_modules_that_programs_import() -> None:
    script = """
import genpy.message, genpy.rostime, roslib.message, rospy.client, rospy.core, rospy.msg, rospy.names
import rospy.numpy_msg, rospy.service, rospy.timer, rospy.topics, tf.transformations, tf2_py
import tf2_geometry_msgs, rospkg.common, message_filters
import roslib; roslib.load_manifest("arm")
print(roslib.message.get_message_class("std_msgs/String"), roslib.message.get_message_class("a/B"))
print(genpy.message.get_service_class("std_srvs/Empty"), genpy.message.get_message_class("time"))
"""
    assert await printed(script) == [
        "<class 'std_msgs.msg.String'> None",
        "<class 'std_srvs.srv.Empty'> <class 'rostether.rospy.client.stamps.Time'>",
    ]


async def test_a_python_whose_version_msgspec_is_not_compiled_for(
    master: str, package: Path, tmp_path: Path
) -> None:
    (tmp_path / "msgspec.py").write_text("raise ImportError")
    script = """
import msgspec, rospy
from arm.msg import Angles
print('stand_in' in msgspec.__file__, Angles(angles=[1, 2]).angles, rospy.Time(1) < rospy.Time(2))
rospy.init_node('arm')
rospy.set_param('~speed', 3)
print(rospy.get_param('~speed'), rospy.get_published_topics('/none'))
"""
    lines = await printed(
        script, master_uri=master, packages={"arm": package}, environ={"PYTHONPATH": str(tmp_path)}
    )
    assert lines == ["True [1, 2] True", "3 []"]
