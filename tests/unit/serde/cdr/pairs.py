"""Converters of types that tests define in a line or two, on both sides."""

from __future__ import annotations

from rostether.msgdef.ros2.parse import parse_message
from rostether.msgdef.ros2.spec import Ros2Message
from rostether.serde.cdr.conversion_tree import DUMMY_NAME, Side
from rostether.serde.cdr.converter import CdrConverter, compile_message
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import TypeTrees
from unit.serde.definitions import TextRegistry

STAMPS = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/msg/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id",
}


class Pairs:
    """Definitions of both sides by their short names in package `test`; a full name stays unchanged."""

    def __init__(self, ros1: dict[str, str], ros2: dict[str, str]) -> None:
        self.registry = TextRegistry({_full(name, "test/"): text for name, text in ros1.items()})
        self.store = TypeStore(self.registry)
        self._ros2 = STAMPS | {_full(name, "test/msg/"): text for name, text in ros2.items()}

    def ros2(self, name: str) -> Ros2Message:
        package, kind, short_name = name.split("/")
        return parse_message(self._ros2[name], package=package, kind=kind, name=short_name)

    def converter(self, ros1: str = "M", ros2: str = "M") -> CdrConverter:
        tree = TypeTrees(self.registry).struct(_full(ros1, "test/"))
        return compile_message(tree, self.ros2(_full(ros2, "test/msg/")), self.ros2)


def pair(ros1: str, ros2: str) -> CdrConverter:
    """Return the converter of two texts."""
    return Pairs({"M": ros1}, {"M": ros2}).converter()


def own_fields(converter: CdrConverter) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the fields that only ROS 1 has, and those that only ROS 2 has."""
    tree = converter._tree
    slots = ((tree.ros1_slots, Side.ROS1), (tree.ros2_slots, Side.ROS2))
    ros1, ros2 = (
        [slot.ros1_name or slot.ros2_name for slot in each if slot.side is side] for each, side in slots
    )
    return tuple(ros1), tuple(name for name in ros2 if name != DUMMY_NAME)


def _full(name: str, prefix: str) -> str:
    return name if "/" in name else prefix + name
