"""The transformers and the listener of tf, the predecessor of tf2; as in ROS since Hydro, they use tf2."""

from __future__ import annotations

import math
from typing import Any

from rostether.robot.transform import (
    Quaternion,
    Transform,
    Vector,
    conjugated,
    multiply,
    rotate,
    transform_of,
)
from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.ros_time import Duration, Time
from rostether.rospy.tf import geometry as tf_geometry
from rostether.rospy.tf import listener_and_broadcasters as tf2_ros
from rostether.rospy.tf import rotations as tf_rotations
from rostether.rospy.tf.buffer import Buffer
from rostether.rospy.tf.exceptions import TransformException


class Transformer:
    """Looks up transforms as lists of numbers; names may begin with a slash.

    A lookup that fails raises tf.Exception, or one of its subclasses, as `Buffer.lookup_transform` does.
    """

    def __init__(self, interpolate: bool = True, cache_time: Any = None) -> None:
        self._buffer = Buffer(cache_time, debug=False)
        self._using_dedicated_thread = False

    def setTransform(self, transform: Any, authority: str = "default_authority") -> None:
        """Store a TransformStamped."""
        self._buffer.set_transform(transform, authority)

    def canTransform(self, target_frame: str, source_frame: str, time: Any) -> bool:
        """Return whether a lookup would succeed."""
        return bool(self._buffer.can_transform(_bare(target_frame), _bare(source_frame), time))

    def canTransformFull(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> bool:
        """Return whether a lookup with two times would succeed."""
        route = (_bare(target_frame), target_time, _bare(source_frame), source_time, _bare(fixed_frame))
        return bool(self._buffer.can_transform_full(*route))

    def waitForTransform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Any,
        polling_sleep_duration: Any = None,
    ) -> None:
        """Wait until a lookup would succeed. Raises tf.Exception at the timeout."""
        self._require_listening()
        can, reason = self._buffer.can_transform(
            _bare(target_frame), _bare(source_frame), time, timeout, return_debug_tuple=True
        )
        if not can:
            raise TransformException(reason)

    def waitForTransformFull(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any,
        polling_sleep_duration: Any = None,
    ) -> None:
        """Wait until a lookup with two times would succeed. Raises tf.Exception at the timeout."""
        self._require_listening()
        route = (_bare(target_frame), target_time, _bare(source_frame), source_time, _bare(fixed_frame))
        can, reason = self._buffer.can_transform_full(*route, timeout, return_debug_tuple=True)
        if not can:
            raise TransformException(reason)

    def lookupTransform(
        self, target_frame: str, source_frame: str, time: Any
    ) -> tuple[list[float], list[float]]:
        """Return the pose of the source in the target: a translation and a quaternion.

        Raises tf.LookupException, ConnectivityException, ExtrapolationException.
        """
        return _lists(self._lookup(target_frame, source_frame, time))

    def lookupTransformFull(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> tuple[list[float], list[float]]:
        """Return the pose of the source at one time in the target at another.

        Raises the same errors as `lookupTransform`.
        """
        route = (_bare(target_frame), target_time, _bare(source_frame), source_time, _bare(fixed_frame))
        return _lists(self._buffer.lookup_transform_full(*route))

    def lookupTwist(
        self, tracking_frame: str, observation_frame: str, time: Any, averaging_interval: Any
    ) -> tuple[Vector, Vector]:
        """Return the linear and angular velocity of a frame, seen from `observation_frame`.

        It is the mean over an interval (a Duration) around `time`.
        """
        return self.lookupTwistFull(
            tracking_frame,
            observation_frame,
            observation_frame,
            (0, 0, 0),
            tracking_frame,
            time,
            averaging_interval,
        )

    def lookupTwistFull(
        self,
        tracking_frame: str,
        observation_frame: str,
        reference_frame: str,
        ref_point: Any,
        reference_point_frame: str,
        time: Any,
        averaging_interval: Any,
    ) -> tuple[Vector, Vector]:
        """Return a velocity like `lookupTwist`, in `reference_frame`; `ref_point` has no effect, as in tf."""
        latest = self.getLatestCommonTime(observation_frame, tracking_frame)
        target = time or latest
        end = min(target + Duration(0.5 * averaging_interval.to_sec()), latest)
        start = max(Time(0.0001) + averaging_interval, end) - averaging_interval
        duration_s = (end - start).to_sec()
        before, after = (
            self._transform(observation_frame, tracking_frame, moment) for moment in (start, end)
        )
        distance = _difference(after.translation, before.translation)
        turn = _rotation_vector(multiply(conjugated(before.rotation), after.rotation))

        tracked = self._transform(reference_frame, tracking_frame, target)
        velocity = rotate(tracked.rotation, _divided(distance, duration_s))
        spin = rotate(tracked.rotation, _divided(turn, duration_s))
        point = self._transform(reference_frame, reference_point_frame, target).apply(tracked.translation)
        # tf adds this product to each axis.
        shift = sum(a * b for a, b in zip(spin, _difference(point, tracked.translation), strict=True))
        (x, y, z), (a, b, c) = tracked.translation, spin
        return (
            velocity[0] + y * c - z * b + shift,
            velocity[1] + z * a - x * c + shift,
            velocity[2] + x * b - y * a + shift,
        ), spin

    def getLatestCommonTime(self, source_frame: str, dest_frame: str) -> Any:
        """Return the latest time at which a lookup succeeds.

        Raises tf.LookupException, ConnectivityException.
        """
        return self._buffer.get_latest_common_time(_bare(source_frame), _bare(dest_frame))

    def frameExists(self, frame_id: str) -> bool:
        """Return whether a frame has a parent."""
        return frame_id in self.getFrameStrings()

    def getFrameStrings(self) -> list[str]:
        """Return the names of the frames that have a parent."""
        return self._buffer.frame_names()

    def allFramesAsString(self) -> str:
        """Return a line for each frame that has a parent."""
        return self._buffer.all_frames_as_string()

    def clear(self) -> None:
        """Remove all transforms."""
        self._buffer.clear()

    def setUsingDedicatedThread(self, value: bool) -> None:
        """Set whether another thread fills the buffer."""
        self._using_dedicated_thread = value

    def getTFPrefix(self) -> str:
        """Return the prefix of frames: empty since tf2."""
        return ""

    def _lookup(self, target_frame: str, source_frame: str, time: Any) -> Any:
        return self._buffer.lookup_transform(_bare(target_frame), _bare(source_frame), time)

    def _transform(self, target_frame: str, source_frame: str, time: Any) -> Transform:
        return transform_of(self._lookup(target_frame, source_frame, time))

    def _require_listening(self) -> None:
        if not self._using_dedicated_thread:
            raise TransformException(
                "cannot wait for transform without a dedicated thread that listens to incoming TF messages"
            )


class TransformerROS(Transformer):
    """A transformer that also transforms stamped messages, with the errors of `lookupTransform`."""

    def asMatrix(self, target_frame: str, hdr: Any) -> Any:
        """Return the transform from a header's frame as a matrix."""
        return self.fromTranslationRotation(*self.lookupTransform(target_frame, hdr.frame_id, hdr.stamp))

    def fromTranslationRotation(self, translation: Any, rotation: Any) -> Any:
        """Return a 4x4 matrix."""
        return tf_rotations.concatenate_matrices(
            tf_rotations.translation_matrix(translation), tf_rotations.quaternion_matrix(rotation)
        )

    def transformPoint(self, target_frame: str, ps: Any) -> Any:
        """Return a PointStamped in another frame."""
        return self._moved(tf_geometry.do_transform_point, target_frame, ps)

    def transformVector3(self, target_frame: str, v3s: Any) -> Any:
        """Return a Vector3Stamped in another frame."""
        return self._moved(tf_geometry.do_transform_vector3, target_frame, v3s)

    def transformQuaternion(self, target_frame: str, ps: Any) -> Any:
        """Return a QuaternionStamped in another frame."""
        return self._moved(tf_geometry.do_transform_quaternion, target_frame, ps)

    def transformPose(self, target_frame: str, ps: Any) -> Any:
        """Return a PoseStamped in another frame."""
        return self._moved(tf_geometry.do_transform_pose, target_frame, ps)

    def transformPointCloud(self, target_frame: str, point_cloud: Any) -> Any:
        """Return a PointCloud in another frame."""
        return self._moved(_moved_cloud, target_frame, point_cloud)

    def _moved(self, function: Any, target_frame: str, message: Any) -> Any:
        header = message.header
        moved = function(message, self._lookup(target_frame, header.frame_id, header.stamp))
        moved.header.stamp = header.stamp
        moved.header.frame_id = target_frame
        return moved


class TransformListener(TransformerROS):
    """A transformer that listens to /tf and /tf_static."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._listener = tf2_ros.TransformListener(self._buffer)
        self.setUsingDedicatedThread(True)

    def unregister(self) -> None:
        """Stop listening."""
        self._listener.unregister()


def _moved_cloud(cloud: Any, message: Any) -> Any:
    transform = transform_of(message)
    point_class: Any = all_types().message_class("geometry_msgs/Point32")
    points = [point_class(*transform.apply((each.x, each.y, each.z))) for each in cloud.points]
    return type(cloud)(points=points, channels=cloud.channels)


def _bare(frame: str) -> str:
    return frame.removeprefix("/")


def _lists(message: Any) -> tuple[list[float], list[float]]:
    transform = transform_of(message)
    return list(transform.translation), list(transform.rotation)


def _difference(left: Vector, right: Vector) -> Vector:
    return left[0] - right[0], left[1] - right[1], left[2] - right[2]


def _divided(vector: Vector, divisor: float) -> Vector:
    return vector[0] / divisor, vector[1] / divisor, vector[2] / divisor


def _rotation_vector(rotation: Quaternion) -> Vector:
    """Return the axis of a rotation, with the angle in radians as its length."""
    x, y, z, w = rotation
    sine = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(math.copysign(sine, w), abs(w))
    return _divided((x * angle, y * angle, z * angle), sine or 1.0)
