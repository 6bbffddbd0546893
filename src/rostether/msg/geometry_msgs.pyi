# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import std_msgs
from rostether.serde.values import Message

class Accel(Message):
    linear: Vector3
    angular: Vector3
    def __init__(self, *, linear: Vector3 | Mapping[str, Any] = ..., angular: Vector3 | Mapping[str, Any] = ...) -> None: ...

class AccelStamped(Message):
    header: std_msgs.Header
    accel: Accel
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., accel: Accel | Mapping[str, Any] = ...) -> None: ...

class AccelWithCovariance(Message):
    accel: Accel
    covariance: list[float]
    def __init__(self, *, accel: Accel | Mapping[str, Any] = ..., covariance: Sequence[float] = ...) -> None: ...

class AccelWithCovarianceStamped(Message):
    header: std_msgs.Header
    accel: AccelWithCovariance
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., accel: AccelWithCovariance | Mapping[str, Any] = ...) -> None: ...

class Inertia(Message):
    m: float
    com: Vector3
    ixx: float
    ixy: float
    ixz: float
    iyy: float
    iyz: float
    izz: float
    def __init__(self, *, m: float = ..., com: Vector3 | Mapping[str, Any] = ..., ixx: float = ..., ixy: float = ..., ixz: float = ..., iyy: float = ..., iyz: float = ..., izz: float = ...) -> None: ...

class InertiaStamped(Message):
    header: std_msgs.Header
    inertia: Inertia
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., inertia: Inertia | Mapping[str, Any] = ...) -> None: ...

class Point(Message):
    x: float
    y: float
    z: float
    def __init__(self, *, x: float = ..., y: float = ..., z: float = ...) -> None: ...

class Point32(Message):
    x: float
    y: float
    z: float
    def __init__(self, *, x: float = ..., y: float = ..., z: float = ...) -> None: ...

class PointStamped(Message):
    header: std_msgs.Header
    point: Point
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., point: Point | Mapping[str, Any] = ...) -> None: ...

class Polygon(Message):
    points: list[Point32]
    def __init__(self, *, points: Sequence[Point32 | Mapping[str, Any]] = ...) -> None: ...

class PolygonStamped(Message):
    header: std_msgs.Header
    polygon: Polygon
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., polygon: Polygon | Mapping[str, Any] = ...) -> None: ...

class Pose(Message):
    position: Point
    orientation: Quaternion
    def __init__(self, *, position: Point | Mapping[str, Any] = ..., orientation: Quaternion | Mapping[str, Any] = ...) -> None: ...

class Pose2D(Message):
    x: float
    y: float
    theta: float
    def __init__(self, *, x: float = ..., y: float = ..., theta: float = ...) -> None: ...

class PoseArray(Message):
    header: std_msgs.Header
    poses: list[Pose]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., poses: Sequence[Pose | Mapping[str, Any]] = ...) -> None: ...

class PoseStamped(Message):
    header: std_msgs.Header
    pose: Pose
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., pose: Pose | Mapping[str, Any] = ...) -> None: ...

class PoseWithCovariance(Message):
    pose: Pose
    covariance: list[float]
    def __init__(self, *, pose: Pose | Mapping[str, Any] = ..., covariance: Sequence[float] = ...) -> None: ...

class PoseWithCovarianceStamped(Message):
    header: std_msgs.Header
    pose: PoseWithCovariance
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., pose: PoseWithCovariance | Mapping[str, Any] = ...) -> None: ...

class Quaternion(Message):
    x: float
    y: float
    z: float
    w: float
    def __init__(self, *, x: float = ..., y: float = ..., z: float = ..., w: float = ...) -> None: ...

class QuaternionStamped(Message):
    header: std_msgs.Header
    quaternion: Quaternion
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., quaternion: Quaternion | Mapping[str, Any] = ...) -> None: ...

class Transform(Message):
    translation: Vector3
    rotation: Quaternion
    def __init__(self, *, translation: Vector3 | Mapping[str, Any] = ..., rotation: Quaternion | Mapping[str, Any] = ...) -> None: ...

class TransformStamped(Message):
    header: std_msgs.Header
    child_frame_id: str
    transform: Transform
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., child_frame_id: str = ..., transform: Transform | Mapping[str, Any] = ...) -> None: ...

class Twist(Message):
    linear: Vector3
    angular: Vector3
    def __init__(self, *, linear: Vector3 | Mapping[str, Any] = ..., angular: Vector3 | Mapping[str, Any] = ...) -> None: ...

class TwistStamped(Message):
    header: std_msgs.Header
    twist: Twist
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., twist: Twist | Mapping[str, Any] = ...) -> None: ...

class TwistWithCovariance(Message):
    twist: Twist
    covariance: list[float]
    def __init__(self, *, twist: Twist | Mapping[str, Any] = ..., covariance: Sequence[float] = ...) -> None: ...

class TwistWithCovarianceStamped(Message):
    header: std_msgs.Header
    twist: TwistWithCovariance
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., twist: TwistWithCovariance | Mapping[str, Any] = ...) -> None: ...

class Vector3(Message):
    x: float
    y: float
    z: float
    def __init__(self, *, x: float = ..., y: float = ..., z: float = ...) -> None: ...

class Vector3Stamped(Message):
    header: std_msgs.Header
    vector: Vector3
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., vector: Vector3 | Mapping[str, Any] = ...) -> None: ...

class Wrench(Message):
    force: Vector3
    torque: Vector3
    def __init__(self, *, force: Vector3 | Mapping[str, Any] = ..., torque: Vector3 | Mapping[str, Any] = ...) -> None: ...

class WrenchStamped(Message):
    header: std_msgs.Header
    wrench: Wrench
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., wrench: Wrench | Mapping[str, Any] = ...) -> None: ...
