# Written by scripts/write-message-stubs.
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rostether import rostime
from rostether.msg import geometry_msgs, std_msgs
from rostether.serde.values import Message

class ImageMarker(Message):
    CIRCLE: int
    LINE_STRIP: int
    LINE_LIST: int
    POLYGON: int
    POINTS: int
    ADD: int
    REMOVE: int
    header: std_msgs.Header
    ns: str
    id: int
    type: int
    action: int
    position: geometry_msgs.Point
    scale: float
    outline_color: std_msgs.ColorRGBA
    filled: int
    fill_color: std_msgs.ColorRGBA
    lifetime: rostime.Duration
    points: list[geometry_msgs.Point]
    outline_colors: list[std_msgs.ColorRGBA]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., ns: str = ..., id: int = ..., type: int = ..., action: int = ..., position: geometry_msgs.Point | Mapping[str, Any] = ..., scale: float = ..., outline_color: std_msgs.ColorRGBA | Mapping[str, Any] = ..., filled: int = ..., fill_color: std_msgs.ColorRGBA | Mapping[str, Any] = ..., lifetime: rostime.Duration | float = ..., points: Sequence[geometry_msgs.Point | Mapping[str, Any]] = ..., outline_colors: Sequence[std_msgs.ColorRGBA | Mapping[str, Any]] = ...) -> None: ...

class InteractiveMarker(Message):
    header: std_msgs.Header
    pose: geometry_msgs.Pose
    name: str
    description: str
    scale: float
    menu_entries: list[MenuEntry]
    controls: list[InteractiveMarkerControl]
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., pose: geometry_msgs.Pose | Mapping[str, Any] = ..., name: str = ..., description: str = ..., scale: float = ..., menu_entries: Sequence[MenuEntry | Mapping[str, Any]] = ..., controls: Sequence[InteractiveMarkerControl | Mapping[str, Any]] = ...) -> None: ...

class InteractiveMarkerControl(Message):
    INHERIT: int
    FIXED: int
    VIEW_FACING: int
    NONE: int
    MENU: int
    BUTTON: int
    MOVE_AXIS: int
    MOVE_PLANE: int
    ROTATE_AXIS: int
    MOVE_ROTATE: int
    MOVE_3D: int
    ROTATE_3D: int
    MOVE_ROTATE_3D: int
    name: str
    orientation: geometry_msgs.Quaternion
    orientation_mode: int
    interaction_mode: int
    always_visible: bool
    markers: list[Marker]
    independent_marker_orientation: bool
    description: str
    def __init__(self, *, name: str = ..., orientation: geometry_msgs.Quaternion | Mapping[str, Any] = ..., orientation_mode: int = ..., interaction_mode: int = ..., always_visible: bool = ..., markers: Sequence[Marker | Mapping[str, Any]] = ..., independent_marker_orientation: bool = ..., description: str = ...) -> None: ...

class InteractiveMarkerFeedback(Message):
    KEEP_ALIVE: int
    POSE_UPDATE: int
    MENU_SELECT: int
    BUTTON_CLICK: int
    MOUSE_DOWN: int
    MOUSE_UP: int
    header: std_msgs.Header
    client_id: str
    marker_name: str
    control_name: str
    event_type: int
    pose: geometry_msgs.Pose
    menu_entry_id: int
    mouse_point: geometry_msgs.Point
    mouse_point_valid: bool
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., client_id: str = ..., marker_name: str = ..., control_name: str = ..., event_type: int = ..., pose: geometry_msgs.Pose | Mapping[str, Any] = ..., menu_entry_id: int = ..., mouse_point: geometry_msgs.Point | Mapping[str, Any] = ..., mouse_point_valid: bool = ...) -> None: ...

class InteractiveMarkerInit(Message):
    server_id: str
    seq_num: int
    markers: list[InteractiveMarker]
    def __init__(self, *, server_id: str = ..., seq_num: int = ..., markers: Sequence[InteractiveMarker | Mapping[str, Any]] = ...) -> None: ...

class InteractiveMarkerPose(Message):
    header: std_msgs.Header
    pose: geometry_msgs.Pose
    name: str
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., pose: geometry_msgs.Pose | Mapping[str, Any] = ..., name: str = ...) -> None: ...

class InteractiveMarkerUpdate(Message):
    KEEP_ALIVE: int
    UPDATE: int
    server_id: str
    seq_num: int
    type: int
    markers: list[InteractiveMarker]
    poses: list[InteractiveMarkerPose]
    erases: list[str]
    def __init__(self, *, server_id: str = ..., seq_num: int = ..., type: int = ..., markers: Sequence[InteractiveMarker | Mapping[str, Any]] = ..., poses: Sequence[InteractiveMarkerPose | Mapping[str, Any]] = ..., erases: Sequence[str] = ...) -> None: ...

class Marker(Message):
    ARROW: int
    CUBE: int
    SPHERE: int
    CYLINDER: int
    LINE_STRIP: int
    LINE_LIST: int
    CUBE_LIST: int
    SPHERE_LIST: int
    POINTS: int
    TEXT_VIEW_FACING: int
    MESH_RESOURCE: int
    TRIANGLE_LIST: int
    ADD: int
    MODIFY: int
    DELETE: int
    DELETEALL: int
    header: std_msgs.Header
    ns: str
    id: int
    type: int
    action: int
    pose: geometry_msgs.Pose
    scale: geometry_msgs.Vector3
    color: std_msgs.ColorRGBA
    lifetime: rostime.Duration
    frame_locked: bool
    points: list[geometry_msgs.Point]
    colors: list[std_msgs.ColorRGBA]
    text: str
    mesh_resource: str
    mesh_use_embedded_materials: bool
    def __init__(self, *, header: std_msgs.Header | Mapping[str, Any] = ..., ns: str = ..., id: int = ..., type: int = ..., action: int = ..., pose: geometry_msgs.Pose | Mapping[str, Any] = ..., scale: geometry_msgs.Vector3 | Mapping[str, Any] = ..., color: std_msgs.ColorRGBA | Mapping[str, Any] = ..., lifetime: rostime.Duration | float = ..., frame_locked: bool = ..., points: Sequence[geometry_msgs.Point | Mapping[str, Any]] = ..., colors: Sequence[std_msgs.ColorRGBA | Mapping[str, Any]] = ..., text: str = ..., mesh_resource: str = ..., mesh_use_embedded_materials: bool = ...) -> None: ...

class MarkerArray(Message):
    markers: list[Marker]
    def __init__(self, *, markers: Sequence[Marker | Mapping[str, Any]] = ...) -> None: ...

class MenuEntry(Message):
    FEEDBACK: int
    ROSRUN: int
    ROSLAUNCH: int
    id: int
    parent_id: int
    title: str
    command: str
    command_type: int
    def __init__(self, *, id: int = ..., parent_id: int = ..., title: str = ..., command: str = ..., command_type: int = ...) -> None: ...
