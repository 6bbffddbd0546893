"""Real ROS 2 reads our CDR, and we read its: random values of every type of the common packages."""

from __future__ import annotations

import importlib
import sys
from functools import cache
from typing import Any

import pytest

from rostether.errors import UnknownTypeError
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.serde.cdr.converter import CdrConverter, compile_message
from rostether.serde.cdr.renamed_types import ros1_message_name
from rostether.serde.codec import Codec
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import TypeTrees
from rostether.serde.values import Message
from unit.serde.random_messages import RandomMessages

pytestmark = [pytest.mark.rclpy, pytest.mark.filterwarnings("ignore::DeprecationWarning")]

PACKAGES = (
    "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rcl_interfaces", "rosgraph_msgs",
    "sensor_msgs", "std_msgs", "std_srvs", "trajectory_msgs",
)  # fmt: skip
ROUNDS = 8
LESS_IN_ROS2 = ("rcl_interfaces/msg/Log",)

DEFINITIONS = Ros2Definitions(prefixes=[sys.prefix], bundled=False)
STORE = TypeStore(Registry())
TREES = TypeTrees(STORE.registry)


def names() -> list[str]:
    """Return all messages that both sides have, halves of services among them."""
    found = []
    for package in PACKAGES:
        found += DEFINITIONS.messages(package)
        found += [
            f"{name}_{half}" for name in DEFINITIONS.services(package) for half in ("Request", "Response")
        ]
    return [name for name in found if is_known(ros1_message_name(name))]


@cache
def is_known(ros1_name: str) -> bool:
    try:
        STORE.codec(ros1_name)
    except UnknownTypeError:
        return False
    return True


def through_ros2(name: str, cdr: bytes) -> bytes:
    """Return the CDR that rclpy writes of the message that it reads in ours."""
    from rclpy.serialization import deserialize_message, serialize_message

    package, kind, short_name = name.split("/")
    message_class: Any = importlib.import_module(f"{package}.{kind}")
    for part in short_name.split("_"):
        message_class = getattr(message_class, part)
    return bytes(serialize_message(deserialize_message(cdr, message_class)))


def as_ros2_keeps_it(value: Any) -> Any:
    """Zero a header's `seq`, end strings before a NUL, as rclpy does, and use severities that there are."""
    if isinstance(value, Message):
        if hasattr(value, "level") and hasattr(value, "topics"):
            value.level = 1 << abs(value.level) % 5
        if hasattr(value, "frame_id") and hasattr(value, "seq"):
            value.seq = 0
        names: tuple[str, ...] = value.__slots__
        for name in names:
            setattr(value, name, as_ros2_keeps_it(getattr(value, name)))
    elif isinstance(value, list):
        return [as_ros2_keeps_it(each) for each in value]
    elif isinstance(value, str):
        return value.partition("\0")[0]
    return value


def require_round_trips(name: str, codec: Codec, converter: CdrConverter) -> None:
    random = RandomMessages(1)
    for _ in range(ROUNDS):
        payload = codec.encode(as_ros2_keeps_it(random.message(codec)))
        cdr = converter.to_cdr(payload)
        back = through_ros2(name, cdr)
        # Fast DDS leaves in padding what was in memory, and bytes at the end that it had counted on.
        assert converter.to_cdr(converter.from_cdr(back)) == cdr
        if name not in LESS_IN_ROS2:
            assert converter.from_cdr(back) == payload


@pytest.mark.parametrize("name", names())
def test_values_come_back(name: str) -> None:
    ros1_name = ros1_message_name(name)
    converter = compile_message(TREES.struct(ros1_name), DEFINITIONS.message(name), DEFINITIONS.message)
    require_round_trips(name, STORE.codec(ros1_name), converter)
