"""Payloads of both sides, and full texts that have to get a ROS 2 form; the first byte chooses the type."""

from __future__ import annotations

from functools import cache

from rostether.errors import RostetherError, SerializationError
from rostether.msgdef.full_text import split_full_text
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.type_support import Ros2Types
from rostether.serde.cdr.converter import CdrConverter
from rostether.serde.layout import Layout
from rostether.serde.store import TypeStore

_NAMES = (
    "std_msgs/String",
    "std_msgs/Empty",
    "sensor_msgs/Imu",
    "sensor_msgs/CameraInfo",
    "sensor_msgs/JointState",
    "sensor_msgs/JoyFeedbackArray",
    "nav_msgs/Path",
    "diagnostic_msgs/DiagnosticArray",
    "visualization_msgs/MarkerArray",
    "shape_msgs/SolidPrimitive",
    "rosgraph_msgs/Log",
)
_TEXT = 0xFF


def seeds() -> list[bytes]:
    """Return a payload and its CDR for every type, and a definition."""
    store = TypeStore(Registry())
    found = [b"\xffHeader header\nuint8 a\nfloat64[] b\nstring frameId\npkg/N[2] n\n" + _PART]
    for index, name in enumerate(_NAMES):
        codec = store.codec(name)
        payload = codec.encode(codec.conform({}))
        found.append(bytes([index]) + payload)
        found.append(bytes([index]) + _converter(name)[0].to_cdr(payload))
    return found


_PART = b"=" * 80 + b"\nMSG: pkg/N\nint16 x\ntime y\n" + b"=" * 80 + (
    b"\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
)  # fmt: skip


def run(data: bytes) -> None:
    """Convert as ROS 1 and as CDR of both byte orders."""
    if not data:
        return
    if data[0] == _TEXT:
        _derive(data[1:].decode("utf-8", "surrogateescape"))
        return
    converter, layout = _converter(_NAMES[data[0] % len(_NAMES)])
    payload = data[1:]
    try:
        cdr = converter.to_cdr(payload)
    except SerializationError as error:
        assert "\n" not in str(error)
        bounded = converter.ros1_name == "shape_msgs/SolidPrimitive" and "at most" in str(error)
        assert bounded or not layout.accepts(payload)
    else:
        assert layout.accepts(payload)
        assert len(converter.from_cdr(cdr)) <= len(payload)
    for whole in (payload, b"\0\1\0\0" + payload[4:], b"\0\0\0\0" + payload[4:]):
        try:
            back = converter.from_cdr(whole)
        except SerializationError as error:
            assert "\n" not in str(error)
        else:
            assert layout.accepts(back)


@cache
def _types() -> Ros2Types:
    return Ros2Types(Registry(), Ros2Definitions())


@cache
def _converter(name: str) -> tuple[CdrConverter, Layout]:
    types = _types()
    return types.message(types.registry.message_type(name)).converter, TypeStore(types.registry).layout(name)


def _derive(text: str) -> None:
    try:
        split_full_text("pkg/Type", text)
        support = Ros2Types(Registry(), _types().definitions).message(MessageType("pkg/Type", "0" * 32, text))
    except RostetherError as error:
        assert "\n" not in str(error)
    else:
        assert support.name == "pkg/msg/Type"
