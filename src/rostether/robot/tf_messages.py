"""Converts transforms to and from tf messages, and publishes them on tf's topics."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from rostether.graph.typed_graph import TypedGraph
from rostether.graph.typed_handles import TypedPublisher
from rostether.robot.transform import StampedTransform, transform_of
from rostether.rostime import Time

TF_TOPIC = "/tf"
TF_STATIC_TOPIC = "/tf_static"
TF_TYPE = "tf2_msgs/TFMessage"


def to_message(transforms: Iterable[StampedTransform]) -> dict[str, Any]:
    """Return the fields of a tf2_msgs/TFMessage."""
    return {"transforms": [_to_fields(each) for each in transforms]}


def from_message(message: Any) -> Iterator[StampedTransform]:
    """Yield the transforms of a tf2_msgs/TFMessage, or of a tf/tfMessage, which has the same fields."""
    for each in message.transforms:
        yield StampedTransform(
            each.header.frame_id, each.child_frame_id, each.header.stamp.to_ns(), transform_of(each)
        )


async def tf_publisher(graph: TypedGraph) -> TypedPublisher[...]:
    """Advertise /tf, for moving transforms."""
    return await graph.publisher(TF_TOPIC, TF_TYPE)


async def tf_static_publisher(graph: TypedGraph) -> TypedPublisher[...]:
    """Advertise /tf_static. New subscribers get only the last message, so send all transforms in one."""
    return await graph.publisher(TF_STATIC_TOPIC, TF_TYPE, latch=True)


def _to_fields(stamped: StampedTransform) -> dict[str, Any]:
    tx, ty, tz = stamped.transform.translation
    x, y, z, w = stamped.transform.rotation
    return {
        "header": {"stamp": Time.from_ns(stamped.stamp_ns), "frame_id": stamped.parent},
        "child_frame_id": stamped.child,
        "transform": {
            "translation": {"x": tx, "y": ty, "z": tz},
            "rotation": {"x": x, "y": y, "z": z, "w": w},
        },
    }
