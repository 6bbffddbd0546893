"""Payloads of ROS 1 and ROS 2, and full texts converted to ROS 2; the first byte selects the type."""

from __future__ import annotations

import random
import struct
from functools import cache

from fuzz.grammar import damaged, string
from rostether.errors import RostetherError, SerializationError
from rostether.msgdef.full_text import split_full_text
from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.types.type_support import Ros2Types
from rostether.serde.cdr.converter import CdrConverter
from rostether.serde.layout import Layout
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import Array, Node, Struct, Text

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
# These have the same fields in ROS 1 and ROS 2, so that the conversion loses nothing.
_ALIKE = ("std_msgs/String", "std_msgs/Empty", "sensor_msgs/JoyFeedbackArray", "shape_msgs/SolidPrimitive")
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


def generate(source: random.Random) -> bytes:
    """Return a payload of a type, or its CDR in either byte order: complete, cut, or with an extra byte."""
    index = source.randrange(len(_NAMES))
    converter, _ = _converter(_NAMES[index])
    payload = _payload(source, _store().codec(_NAMES[index]).tree)
    if source.random() < 0.4:
        try:
            payload = converter.to_cdr(payload)
        except SerializationError:
            return bytes([index]) + payload
    chance = source.random()
    if chance < 0.1:
        payload = damaged(source, payload)
    return bytes([index]) + (payload + b"\0" if 0.1 <= chance < 0.2 else payload)


def _payload(source: random.Random, node: Node) -> bytes:
    if isinstance(node, Struct):
        return b"".join(_payload(source, member.node) for member in node.members)
    if isinstance(node, Array):
        count = source.choice((0, 1, 2, 3, 5)) if node.length is None else node.length
        head = struct.pack("<I", count) if node.length is None else b""
        return head + b"".join(_payload(source, node.element) for _ in range(count))
    if isinstance(node, Text):
        return string(source.choice((b"", b"a", b"abc", b"a\0", b"\xff")))
    size = node.fixed_size_bytes
    return bytes([source.randrange(2)]) if node.name == "bool" else source.randbytes(size)


_PART = b"=" * 80 + b"\nMSG: pkg/N\nint16 x\ntime y\n" + b"=" * 80 + (
    b"\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
)  # fmt: skip


def run(data: bytes) -> None:
    """Convert the data as ROS 1, and as CDR in both byte orders."""
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
        assert _is_read_whole(layout.type_name, payload)
        back = converter.from_cdr(cdr)
        assert len(back) <= len(payload)
        if layout.type_name in _ALIKE:
            # In CDR, a NUL ends a string.
            assert back == payload or b"\0" in payload, "the conversion there and back changes the message"
            again = converter.to_cdr(back)
            assert converter.from_cdr(again) == back
    for whole in (payload, b"\0\1\0\0" + payload[4:], b"\0\0\0\0" + payload[4:]):
        try:
            back = converter.from_cdr(whole)
        except SerializationError as error:
            assert "\n" not in str(error)
        else:
            assert layout.accepts(back)


def _is_read_whole(name: str, payload: bytes) -> bool:
    """Return whether the values of a payload use all of its bytes."""
    codec = _store().codec(name)
    return len(codec.encode(codec.decode(payload))) == len(payload)


@cache
def _store() -> TypeStore:
    return TypeStore(Registry())


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
