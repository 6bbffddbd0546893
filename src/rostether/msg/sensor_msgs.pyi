# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import geometry_msgs, std_msgs
from rostether.serde.values import Message

class BatteryState(Message):
    POWER_SUPPLY_STATUS_UNKNOWN: int
    POWER_SUPPLY_STATUS_CHARGING: int
    POWER_SUPPLY_STATUS_DISCHARGING: int
    POWER_SUPPLY_STATUS_NOT_CHARGING: int
    POWER_SUPPLY_STATUS_FULL: int
    POWER_SUPPLY_HEALTH_UNKNOWN: int
    POWER_SUPPLY_HEALTH_GOOD: int
    POWER_SUPPLY_HEALTH_OVERHEAT: int
    POWER_SUPPLY_HEALTH_DEAD: int
    POWER_SUPPLY_HEALTH_OVERVOLTAGE: int
    POWER_SUPPLY_HEALTH_UNSPEC_FAILURE: int
    POWER_SUPPLY_HEALTH_COLD: int
    POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE: int
    POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE: int
    POWER_SUPPLY_TECHNOLOGY_UNKNOWN: int
    POWER_SUPPLY_TECHNOLOGY_NIMH: int
    POWER_SUPPLY_TECHNOLOGY_LION: int
    POWER_SUPPLY_TECHNOLOGY_LIPO: int
    POWER_SUPPLY_TECHNOLOGY_LIFE: int
    POWER_SUPPLY_TECHNOLOGY_NICD: int
    POWER_SUPPLY_TECHNOLOGY_LIMN: int
    header: std_msgs.Header
    voltage: float
    temperature: float
    current: float
    charge: float
    capacity: float
    design_capacity: float
    percentage: float
    power_supply_status: int
    power_supply_health: int
    power_supply_technology: int
    present: bool
    cell_voltage: list[float]
    cell_temperature: list[float]
    location: str
    serial_number: str
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., voltage: float = ..., temperature: float = ..., current: float = ..., charge: float = ..., capacity: float = ..., design_capacity: float = ..., percentage: float = ..., power_supply_status: int = ..., power_supply_health: int = ..., power_supply_technology: int = ..., present: bool = ..., cell_voltage: Sequence[float] = ..., cell_temperature: Sequence[float] = ..., location: str = ..., serial_number: str = ...) -> None: ...

class CameraInfo(Message):
    header: std_msgs.Header
    height: int
    width: int
    distortion_model: str
    D: list[float]
    K: list[float]
    R: list[float]
    P: list[float]
    binning_x: int
    binning_y: int
    roi: RegionOfInterest
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., height: int = ..., width: int = ..., distortion_model: str = ..., D: Sequence[float] = ..., K: Sequence[float] = ..., R: Sequence[float] = ..., P: Sequence[float] = ..., binning_x: int = ..., binning_y: int = ..., roi: RegionOfInterest | Mapping[str, Any] = ...) -> None: ...

class ChannelFloat32(Message):
    name: str
    values: list[float]
    def __init__(self, *, name: str = ..., values: Sequence[float] = ...) -> None: ...

class CompressedImage(Message):
    header: std_msgs.Header
    format: str
    data: bytes
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., format: str = ..., data: bytes | Sequence[int] = ...) -> None: ...

class FluidPressure(Message):
    header: std_msgs.Header
    fluid_pressure: float
    variance: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., fluid_pressure: float = ..., variance: float = ...) -> None: ...

class Illuminance(Message):
    header: std_msgs.Header
    illuminance: float
    variance: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., illuminance: float = ..., variance: float = ...) -> None: ...

class Image(Message):
    header: std_msgs.Header
    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: bytes
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., height: int = ..., width: int = ..., encoding: str = ..., is_bigendian: int = ..., step: int = ..., data: bytes | Sequence[int] = ...) -> None: ...

class Imu(Message):
    header: std_msgs.Header
    orientation: geometry_msgs.Quaternion
    orientation_covariance: list[float]
    angular_velocity: geometry_msgs.Vector3
    angular_velocity_covariance: list[float]
    linear_acceleration: geometry_msgs.Vector3
    linear_acceleration_covariance: list[float]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., orientation: geometry_msgs.Quaternion | Mapping[str, Any] = ..., orientation_covariance: Sequence[float] = ..., angular_velocity: geometry_msgs.Vector3 | Mapping[str, Any] = ..., angular_velocity_covariance: Sequence[float] = ..., linear_acceleration: geometry_msgs.Vector3 | Mapping[str, Any] = ..., linear_acceleration_covariance: Sequence[float] = ...) -> None: ...

class JointState(Message):
    header: std_msgs.Header
    name: list[str]
    position: list[float]
    velocity: list[float]
    effort: list[float]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., name: Sequence[str] = ..., position: Sequence[float] = ..., velocity: Sequence[float] = ..., effort: Sequence[float] = ...) -> None: ...

class Joy(Message):
    header: std_msgs.Header
    axes: list[float]
    buttons: list[int]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., axes: Sequence[float] = ..., buttons: Sequence[int] = ...) -> None: ...

class JoyFeedback(Message):
    TYPE_LED: int
    TYPE_RUMBLE: int
    TYPE_BUZZER: int
    type: int
    id: int
    intensity: float
    def __init__(self, *, type: int = ..., id: int = ..., intensity: float = ...) -> None: ...

class JoyFeedbackArray(Message):
    array: list[JoyFeedback]
    def __init__(self, *, array: Sequence[JoyFeedback | Mapping[str, Any]] = ...) -> None: ...

class LaserEcho(Message):
    echoes: list[float]
    def __init__(self, *, echoes: Sequence[float] = ...) -> None: ...

class LaserScan(Message):
    header: std_msgs.Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: list[float]
    intensities: list[float]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., angle_min: float = ..., angle_max: float = ..., angle_increment: float = ..., time_increment: float = ..., scan_time: float = ..., range_min: float = ..., range_max: float = ..., ranges: Sequence[float] = ..., intensities: Sequence[float] = ...) -> None: ...

class MagneticField(Message):
    header: std_msgs.Header
    magnetic_field: geometry_msgs.Vector3
    magnetic_field_covariance: list[float]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., magnetic_field: geometry_msgs.Vector3 | Mapping[str, Any] = ..., magnetic_field_covariance: Sequence[float] = ...) -> None: ...

class MultiDOFJointState(Message):
    header: std_msgs.Header
    joint_names: list[str]
    transforms: list[geometry_msgs.Transform]
    twist: list[geometry_msgs.Twist]
    wrench: list[geometry_msgs.Wrench]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., joint_names: Sequence[str] = ..., transforms: Sequence[geometry_msgs.Transform | Mapping[str, Any]] = ..., twist: Sequence[geometry_msgs.Twist | Mapping[str, Any]] = ..., wrench: Sequence[geometry_msgs.Wrench | Mapping[str, Any]] = ...) -> None: ...

class MultiEchoLaserScan(Message):
    header: std_msgs.Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: list[LaserEcho]
    intensities: list[LaserEcho]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., angle_min: float = ..., angle_max: float = ..., angle_increment: float = ..., time_increment: float = ..., scan_time: float = ..., range_min: float = ..., range_max: float = ..., ranges: Sequence[LaserEcho | Mapping[str, Any]] = ..., intensities: Sequence[LaserEcho | Mapping[str, Any]] = ...) -> None: ...

class NavSatFix(Message):
    COVARIANCE_TYPE_UNKNOWN: int
    COVARIANCE_TYPE_APPROXIMATED: int
    COVARIANCE_TYPE_DIAGONAL_KNOWN: int
    COVARIANCE_TYPE_KNOWN: int
    header: std_msgs.Header
    status: NavSatStatus
    latitude: float
    longitude: float
    altitude: float
    position_covariance: list[float]
    position_covariance_type: int
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., status: NavSatStatus | Mapping[str, Any] = ..., latitude: float = ..., longitude: float = ..., altitude: float = ..., position_covariance: Sequence[float] = ..., position_covariance_type: int = ...) -> None: ...

class NavSatStatus(Message):
    STATUS_NO_FIX: int
    STATUS_FIX: int
    STATUS_SBAS_FIX: int
    STATUS_GBAS_FIX: int
    SERVICE_GPS: int
    SERVICE_GLONASS: int
    SERVICE_COMPASS: int
    SERVICE_GALILEO: int
    status: int
    service: int
    def __init__(self, *, status: int = ..., service: int = ...) -> None: ...

class PointCloud(Message):
    header: std_msgs.Header
    points: list[geometry_msgs.Point32]
    channels: list[ChannelFloat32]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., points: Sequence[geometry_msgs.Point32 | Mapping[str, Any]] = ..., channels: Sequence[ChannelFloat32 | Mapping[str, Any]] = ...) -> None: ...

class PointCloud2(Message):
    header: std_msgs.Header
    height: int
    width: int
    fields: list[PointField]
    is_bigendian: bool
    point_step: int
    row_step: int
    data: bytes
    is_dense: bool
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., height: int = ..., width: int = ..., fields: Sequence[PointField | Mapping[str, Any]] = ..., is_bigendian: bool = ..., point_step: int = ..., row_step: int = ..., data: bytes | Sequence[int] = ..., is_dense: bool = ...) -> None: ...

class PointField(Message):
    INT8: int
    UINT8: int
    INT16: int
    UINT16: int
    INT32: int
    UINT32: int
    FLOAT32: int
    FLOAT64: int
    name: str
    offset: int
    datatype: int
    count: int
    def __init__(self, *, name: str = ..., offset: int = ..., datatype: int = ..., count: int = ...) -> None: ...

class Range(Message):
    ULTRASOUND: int
    INFRARED: int
    header: std_msgs.Header
    radiation_type: int
    field_of_view: float
    min_range: float
    max_range: float
    range: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., radiation_type: int = ..., field_of_view: float = ..., min_range: float = ..., max_range: float = ..., range: float = ...) -> None: ...

class RegionOfInterest(Message):
    x_offset: int
    y_offset: int
    height: int
    width: int
    do_rectify: bool
    def __init__(self, *, x_offset: int = ..., y_offset: int = ..., height: int = ..., width: int = ..., do_rectify: bool = ...) -> None: ...

class RelativeHumidity(Message):
    header: std_msgs.Header
    relative_humidity: float
    variance: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., relative_humidity: float = ..., variance: float = ...) -> None: ...

class Temperature(Message):
    header: std_msgs.Header
    temperature: float
    variance: float
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., temperature: float = ..., variance: float = ...) -> None: ...

class TimeReference(Message):
    header: std_msgs.Header
    time_ref: rostime.Time
    source: str
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., time_ref: rostime.Time | float | Literal["now"] = ..., source: str = ...) -> None: ...
