"""static_transform_publisher: publishes a transform given by arguments or by a parameter.

X Y Z YAW PITCH ROLL PARENT CHILD            on /tf_static (tf2_ros)
X Y Z QX QY QZ QW PARENT CHILD               the same
PARAMETER                                    the same, for a geometry_msgs/TransformStamped as YAML
--x X ... --frame-id PARENT --child-frame-id CHILD  the same, as in ROS 2
X Y Z YAW PITCH ROLL PARENT CHILD PERIOD_MS  on /tf, repeatedly (tf)
X Y Z QX QY QZ QW PARENT CHILD PERIOD_MS     the same
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.graph.ports import ParamValue
from rostether.graph.typed_graph import TypedGraph
from rostether.mechanisms.tasks import run_until
from rostether.robot.tf_messages import tf_publisher, tf_static_publisher, to_message
from rostether.robot.transform import (
    Quaternion,
    StampedTransform,
    Transform,
    has_unit_length,
    quaternion_from_rpy,
)

_TRANSLATION = ("--x", "--y", "--z")
_ANGLES = ("--yaw", "--pitch", "--roll")
_QUATERNION = ("--qx", "--qy", "--qz", "--qw")
_FRAMES = ("--frame-id", "--child-frame-id")

USAGE = "write X Y Z YAW PITCH ROLL PARENT CHILD, or X Y Z QX QY QZ QW PARENT CHILD"


class StaticTransform(Struct, frozen=True):
    """The transform to publish: repeatedly on /tf with a period, once on /tf_static without one."""

    parent: str
    child: str
    transform: Transform
    period_s: float | None = None


def parse_static_transform(words: Sequence[str]) -> StaticTransform:
    """Read the arguments in one of the forms above, except PARAMETER. Raises ConfigError."""
    if any(word.startswith("--") for word in words):
        words = _in_order(words)
    count = len(words)
    has_quaternion = count == 10 or (count == 9 and _is_number(words[6]))
    if not 8 <= count <= 10:
        raise ConfigError(f"{count} arguments are not a transform; {USAGE}")
    numbers = [_number(word) for word in words[: 7 if has_quaternion else 6]]
    names = words[len(numbers) :]
    if has_quaternion:
        rotation: Quaternion = (numbers[3], numbers[4], numbers[5], numbers[6])
    else:
        rotation = quaternion_from_rpy(numbers[5], numbers[4], numbers[3])
    period_s = None
    if len(names) == 3:
        period_s = _number(names[2]) / 1000.0
        if period_s <= 0:
            raise ConfigError(f"the period {names[2]!r} must be a positive number of milliseconds")
    transform = Transform((numbers[0], numbers[1], numbers[2]), rotation)
    return _checked(StaticTransform(names[0], names[1], transform, period_s))


def _in_order(words: Sequence[str]) -> list[str]:
    """Return the values of `--x 1 --frame-id map`, in the order of the other forms. Raises ConfigError."""
    known = (*_TRANSLATION, *_ANGLES, *_QUATERNION, *_FRAMES)
    given: dict[str, str] = {}
    for option, value in zip_longest(words[::2], words[1::2]):
        if option not in known:
            raise ConfigError(f"{option!r} is not an option of a transform; known: {', '.join(known)}")
        if value is None:
            raise ConfigError(f"{option} has no value; write one after it")
        given[option] = value
    if missing := [each for each in _FRAMES if each not in given]:
        raise ConfigError(f"the transform has no {' and no '.join(missing)}; add the name of the frame")
    has_quaternion = not given.keys().isdisjoint(_QUATERNION)
    if has_quaternion and not given.keys().isdisjoint(_ANGLES):
        raise ConfigError("a rotation is a quaternion or angles; omit one of them")
    rotation = _QUATERNION if has_quaternion else _ANGLES
    return [given.get(each, "1" if each == "--qw" else "0") for each in (*_TRANSLATION, *rotation, *_FRAMES)]


def static_transform_of(value: ParamValue, name: str) -> StaticTransform:
    """Read a parameter with the fields of a geometry_msgs/TransformStamped. Raises ConfigError."""
    content: Any = value
    try:
        translation, rotation = content["transform"]["translation"], content["transform"]["rotation"]
        x, y, z = (_number(str(translation[axis])) for axis in "xyz")
        qx, qy, qz, qw = (_number(str(rotation[axis])) for axis in "xyzw")
        transform = Transform((x, y, z), (qx, qy, qz, qw))
        parent, child = str(content["header"]["frame_id"]), str(content["child_frame_id"])
    except (KeyError, TypeError) as error:
        missing = f": it has no {error}" if isinstance(error, KeyError) else ""
        raise ConfigError(
            f"the parameter {name} does not have the fields of a geometry_msgs/TransformStamped{missing}"
        ) from None
    return _checked(StaticTransform(parent, child, transform))


async def publish_static_transform(graph: TypedGraph, static: StaticTransform) -> None:
    """Publish until canceled or the node is shut down."""
    await run_until(_publish(graph, static), graph.raw.wait_closed())


async def _publish(graph: TypedGraph, static: StaticTransform) -> None:
    if static.period_s is None:
        publisher = await tf_static_publisher(graph)
        publisher.publish(to_message([_stamped(static, graph.now().to_ns())]))
        await asyncio.Event().wait()
        return
    publisher = await tf_publisher(graph)
    while True:
        # As in tf, the stamp is in the future, so that the transform is valid until the next one arrives.
        ahead_ns = graph.now().to_ns() + round(static.period_s * 1e9)
        publisher.publish(to_message([_stamped(static, ahead_ns)]))
        await asyncio.sleep(static.period_s)


def _stamped(static: StaticTransform, stamp_ns: int) -> StampedTransform:
    return StampedTransform(static.parent, static.child, stamp_ns, static.transform)


def _checked(static: StaticTransform) -> StaticTransform:
    if not static.parent or not static.child:
        raise ConfigError(f"the parent or child frame has no name; {USAGE}")
    if static.parent == static.child:
        raise ConfigError(f"parent and child frame are both {static.parent!r}; give two different frames")
    if not has_unit_length(static.transform.rotation):
        shown = " ".join(f"{each:g}" for each in static.transform.rotation)
        raise ConfigError(f"the quaternion {shown} does not have length 1, so tf rejects it; normalize it")
    return static


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _number(text: str) -> float:
    if not _is_number(text):
        raise ConfigError(f"{text!r} is not a number; {USAGE}")
    return float(text)
