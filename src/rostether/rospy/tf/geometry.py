"""Points, vectors, poses and wrenches in another frame, for tf2_geometry_msgs and tf's listener."""

from __future__ import annotations

from typing import Any

from rostether.robot.transform import multiply, rotate, transform_of
from rostether.rospy.client.message_types import all_types
from rostether.rospy.tf.buffer_interface import TransformRegistration


def do_transform_point(point: Any, transform: Any) -> Any:
    """Return a PointStamped in the transform's parent frame."""
    result = _stamped("PointStamped", transform)
    _set_xyz(result.point, transform_of(transform).apply(_xyz(point.point)))
    return result


def do_transform_vector3(vector3: Any, transform: Any) -> Any:
    """Return a Vector3Stamped, rotated into the transform's parent frame."""
    result = _stamped("Vector3Stamped", transform)
    _set_xyz(result.vector, rotate(transform_of(transform).rotation, _xyz(vector3.vector)))
    return result


def do_transform_pose(pose: Any, transform: Any) -> Any:
    """Return a PoseStamped in the transform's parent frame."""
    result = _stamped("PoseStamped", transform)
    rigid = transform_of(transform)
    _set_xyz(result.pose.position, rigid.apply(_xyz(pose.pose.position)))
    _set_xyzw(result.pose.orientation, multiply(rigid.rotation, _xyzw(pose.pose.orientation)))
    return result


def do_transform_quaternion(quaternion: Any, transform: Any) -> Any:
    """Return a QuaternionStamped in the transform's parent frame."""
    result = _stamped("QuaternionStamped", transform)
    turned = multiply(transform_of(transform).rotation, _xyzw(quaternion.quaternion))
    _set_xyzw(result.quaternion, turned)
    return result


def do_transform_wrench(wrench: Any, transform: Any) -> Any:
    """Return a WrenchStamped, rotated into the transform's parent frame."""
    result = _stamped("WrenchStamped", transform)
    rotation = transform_of(transform).rotation
    _set_xyz(result.wrench.force, rotate(rotation, _xyz(wrench.wrench.force)))
    _set_xyz(result.wrench.torque, rotate(rotation, _xyz(wrench.wrench.torque)))
    return result


def transform_message(parent: str, child: str, stamp: Any, translation: Any, rotation: Any) -> Any:
    """Return a TransformStamped: the pose of the frame `child` in `parent`."""
    message: Any = all_types().message_class("geometry_msgs/TransformStamped")()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    _set_xyz(message.transform.translation, translation)
    _set_xyzw(message.transform.rotation, rotation)
    return message


def register() -> None:
    """Let buffers transform these types."""
    registration = TransformRegistration()
    for name, function in (
        ("PointStamped", do_transform_point),
        ("Vector3Stamped", do_transform_vector3),
        ("PoseStamped", do_transform_pose),
        ("WrenchStamped", do_transform_wrench),
        ("QuaternionStamped", do_transform_quaternion),
    ):
        registration.add(all_types().message_class(f"geometry_msgs/{name}"), function)


def _stamped(name: str, transform: Any) -> Any:
    message: Any = all_types().message_class(f"geometry_msgs/{name}")()
    message.header.stamp = transform.header.stamp
    message.header.frame_id = transform.header.frame_id
    return message


def _xyz(value: Any) -> tuple[float, float, float]:
    return value.x, value.y, value.z


def _xyzw(value: Any) -> tuple[float, float, float, float]:
    return value.x, value.y, value.z, value.w


def _set_xyz(message: Any, values: tuple[float, float, float]) -> None:
    message.x, message.y, message.z = values


def _set_xyzw(message: Any, values: tuple[float, float, float, float]) -> None:
    message.x, message.y, message.z, message.w = values
