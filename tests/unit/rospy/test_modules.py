"""tf, message_filters, rosparam and rosgraph without ROS; tests/interop compares them with Debian's."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.rospy.tf import matrices
from rostether.rospy.tf import rotations as tf_rotations
from unit.rospy.programs import printed

SCRIPTS = Path(__file__).parents[2] / "interop" / "rospy_scripts"


async def test_frames(master: str) -> None:
    lines = await printed(SCRIPTS / "frames.py", master_uri=master)
    assert "10500000000 world arm" in lines
    assert any(line.startswith("future raises ExtrapolationException Lookup would require") for line in lines)
    assert any(line.startswith("apart raises ConnectivityException") for line in lines)
    assert "['dock', 'odom', 'wheel'] True" in lines
    assert any(line.startswith("twist [[1.614534109, -0.377809946") for line in lines)
    assert "True True True True" in lines


async def test_functions_are_those_of_rospy() -> None:
    script = """
import inspect, actionlib, actionlib.goal_id_generator, rosbag, rospy, tf2_ros
for name in ("get_param_cached", "on_shutdown", "resolve_name", "signal_shutdown"):
    print(name == getattr(rospy, name).__name__, list(inspect.signature(getattr(rospy, name)).parameters))
for owner in (tf2_ros.BufferInterface.lookup_transform_full, tf2_ros.BufferClient.can_transform_full):
    print(list(inspect.signature(owner).parameters)[1:])
print([type(getattr(rosbag.Bag, name)).__name__ for name in ("filename", "mode", "version")])
print(hasattr(actionlib.goal_id_generator, "ServerGoalHandle"))
event = rospy.timer.TimerEvent(None, None, rospy.Time(1), rospy.Time(2), None)
event.note = "seen"
print({event: event.note}[event])
"""
    times = ["target_frame", "target_time", "source_frame", "source_time", "fixed_frame", "timeout"]
    assert await printed(script) == [
        "True ['param_name', 'default']",
        "True ['h']",
        "True ['name', 'caller_id']",
        "True ['reason']",
        f"{times}",
        f"{times}",
        "['property', 'property', 'property']",
        "False",
        "seen",
    ]


async def test_rotations_of_tf_conversions() -> None:
    script = "import tf_conversions; print(tf_conversions.transformations.quaternion_from_euler(0, 0, 0)[3])"
    assert await printed(script) == ["1.0"]


async def test_message_filters_combine_topics(master: str) -> None:
    lines = await printed(SCRIPTS / "filters.py", master_uri=master)
    assert "exact [('a', 1000000000), ('d', 1000000000)]" in lines
    assert "near [('a', 1000000000), ('b', 1050000000), ('e', 1040000000)]" in lines


async def test_the_masters_api_and_parameter_files(master: str) -> None:
    lines = await printed(SCRIPTS / "tools.py", master_uri=master)
    assert lines[0] == "True True"
    assert "lookup raises MasterError" in lines


async def test_the_functions_of_rosparam_without_a_master() -> None:
    script = (
        "import rosparam\n"
        "for call in (\n"
        "    lambda: rosparam.get_param('/a'), lambda: rosparam.set_param('/a', '1'),\n"
        "    lambda: rosparam.upload_params('/a', {'b': 1}), lambda: rosparam.delete_param('/a'),\n"
        "    lambda: rosparam.list_params('/'), lambda: rosparam.dump_params('', '/a'),\n"
        "):\n"
        "    try:\n"
        "        call()\n"
        "    except rosparam.RosParamIOException as error:\n"
        "        print(error)\n"
    )
    lines = await printed(script, master_uri="http://127.0.0.1:1")
    assert lines == ["Unable to communicate with master!"] * 6


async def test_a_value_that_no_parameter_can_have_is_refused(master: str) -> None:
    script = (
        "import rosparam, rosgraph, rospy\n"
        "for call in (\n"
        "    lambda: rosparam.set_param('/a', 'null'), lambda: rosparam.set_param('/a/b', '68719476736'),\n"
        "    lambda: rospy.set_param('/a', None), lambda: rosgraph.Master('/me').setParam('/a', None),\n"
        "):\n"
        "    try:\n"
        "        call()\n"
        "    except (rosparam.RosParamException, ValueError) as error:\n"
        "        print(isinstance(error, rosparam.RosParamException), error)\n"
    )
    no_value, large, none, master_none = await printed(script, master_uri=master)
    assert no_value.startswith("True /a: XML-RPC cannot carry None")
    assert large.startswith("True /a/b: 68719476736 does not fit in")
    assert none == master_none == no_value.replace("True /a:", "False")


async def test_lookups_of_the_graph(master: str) -> None:
    lines = await printed(SCRIPTS / "lookups.py", master_uri=master)
    assert "/look/poses/pose/position/x geometry_msgs/PoseStamped /look/poses True" in lines
    assert "/lookups ['/look/set']" in lines
    assert "std_srvs/SetBool None" in lines


async def test_point_clouds() -> None:
    lines = await printed(SCRIPTS / "clouds.py")
    assert "[(1.0, 2.0, 3.0), (7.5, 8.0, 9.0)] 3" in lines
    assert "[(515,), (1543,), (2828,), (3856,)]" in lines


async def test_point_clouds_next_to_messages_of_ros_2(tmp_path: Path) -> None:
    (tmp_path / "sensor_msgs").mkdir()
    (tmp_path / "sensor_msgs" / "__init__.py").touch()
    script = "import sensor_msgs.point_cloud2 as pc2; print(pc2.create_cloud_xyz32(None, []).point_step)"
    assert await printed(script, environ={"PYTHONPATH": str(tmp_path)}) == ["12"]


@pytest.mark.parametrize("axes", ["sxyz", "rzyx", "sxyx", "rzxz", "syxz"])
def test_euler_angles_survive_a_round_trip(axes: str) -> None:
    angles = (0.3, 0.9, -1.2)
    found = tf_rotations.euler_from_quaternion(tf_rotations.quaternion_from_euler(*angles, axes), axes)
    assert found == pytest.approx(angles)


@pytest.mark.parametrize("axes", ["xyz", "sxxz", "qxyz", "sxyw"])
def test_invalid_axes_are_refused(axes: str) -> None:
    with pytest.raises(ValueError, match="are not axes;"):
        tf_rotations.quaternion_from_euler(1, 2, 3, axes)


def test_a_matrix_and_its_inverse() -> None:
    matrix = tf_rotations.concatenate_matrices(
        tf_rotations.translation_matrix((1, 2, 3)), tf_rotations.rotation_matrix(0.5, (1, 1, 0))
    )
    product = tf_rotations.concatenate_matrices(matrix, tf_rotations.inverse_matrix(matrix))
    for row, wanted in zip(product, tf_rotations.identity_matrix(), strict=True):
        assert list(row) == pytest.approx(list(wanted))


def test_a_shear_survives_a_round_trip() -> None:
    made = matrices.shear_matrix(-0.4, (0, 2, 0), (1, 2, 3), (3, 0, 0))
    angle, direction, point, normal = matrices.shear_from_matrix(made)
    assert matrices.is_same_transform(matrices.shear_matrix(angle, direction, point, normal), made)
    with pytest.raises(ValueError, match="the matrix is not a shear"):
        matrices.shear_from_matrix(tf_rotations.identity_matrix())
