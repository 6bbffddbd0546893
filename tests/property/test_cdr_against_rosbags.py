"""The conversion has the same result as that of rosbags, for every type that has definitions of ROS 1 and ROS
2.
"""

from __future__ import annotations

from typing import Any

import pytest

from rostether.errors import DefinitionError
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.serde.cdr.converter import compile_message
from rostether.serde.cdr.renamed_types import ros2_message_name
from rostether.serde.store import TypeStore
from rostether.serde.type_tree import TypeTrees
from unit.serde.random_messages import RandomMessages

rosbags_typesys = pytest.importorskip("rosbags.typesys")

STORE = TypeStore(Registry())
DEFINITIONS = Ros2Definitions()
ROSBAGS: Any = rosbags_typesys.get_typestore(rosbags_typesys.Stores.ROS2_JAZZY)
# rosbags converts within one definition; types with another layout in ROS 2 need both definitions.
CHANGED = {
    "sensor_msgs/Range",
    "shape_msgs/SolidPrimitive",
    "visualization_msgs/InteractiveMarker",
    "visualization_msgs/InteractiveMarkerControl",
    "visualization_msgs/InteractiveMarkerInit",
    "visualization_msgs/InteractiveMarkerUpdate",
    "visualization_msgs/Marker",
    "visualization_msgs/MarkerArray",
}
ROUNDS = 5


def is_comparable(name: str) -> bool:
    if name in CHANGED or name.replace("/", "/msg/") not in ROSBAGS.types:
        return False
    try:
        DEFINITIONS.message(ros2_message_name(name))
    except DefinitionError:
        return False
    return True


TYPES = [name for name in STORE.registry.messages() if is_comparable(name)]


def test_most_types_are_compared() -> None:
    assert len(TYPES) > 100


@pytest.mark.parametrize("name", TYPES)
def test_rosbags_writes_the_same_bytes(name: str) -> None:
    codec, random = STORE.codec(name), RandomMessages(2)
    ros2 = DEFINITIONS.message(ros2_message_name(name))
    converter = compile_message(TypeTrees(STORE.registry).struct(name), ros2, DEFINITIONS.message)
    for _ in range(ROUNDS):
        payload = codec.encode(random.message(codec))
        cdr = converter.to_cdr(payload)
        rosbags_name = name.replace("/", "/msg/")
        assert bytes(ROSBAGS.ros1_to_cdr(payload, rosbags_name)) == cdr
        # The `seq` of a header is lost: ROS 2 has no such field.
        back = converter.from_cdr(cdr)
        assert len(back) == len(payload)
        assert bytes(ROSBAGS.ros1_to_cdr(back, rosbags_name)) == cdr
