"""The ROS 2 form of a type that exists only as a ROS 1 text, as in a manual port.

`time` and `duration` become messages of builtin_interfaces, `std_msgs/Header` is that of ROS 2 without seq,
and field names become lowercase (`frameId` -> `frame_id`). The rest, such as the type's name, is unchanged.
"""

from __future__ import annotations

import re
from types import MappingProxyType

from rostether.errors import DefinitionError
from rostether.msgdef.primitives import PRIMITIVE_TYPES
from rostether.msgdef.registry import Registry
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.ros2.parse import is_constant_name, is_field_name
from rostether.msgdef.ros2.primitives import INTEGER_RANGES
from rostether.msgdef.ros2.spec import Ros2Constant, Ros2Field, Ros2Message, Ros2Type
from rostether.msgdef.spec import Constant, Field, MessageSpec

_TIME = "builtin_interfaces/msg/Time"
_DURATION = "builtin_interfaces/msg/Duration"
# Messages with another name in ROS 2; std_msgs/Time and Duration became the type of their only field.
RENAMED_MESSAGES = MappingProxyType(
    {
        "rosgraph_msgs/Log": "rcl_interfaces/msg/Log",
        "std_msgs/Duration": _DURATION,
        "std_msgs/Time": _TIME,
        "tf/tfMessage": "tf2_msgs/msg/TFMessage",
    }
)
_RENAMED = {
    **RENAMED_MESSAGES,
    "time": _TIME,
    "duration": _DURATION,
    "roslib/Header": "std_msgs/msg/Header",
}
_BEFORE_CAPITALS = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")


def derive(spec: MessageSpec, registry: Registry) -> Ros2Message:
    """Return the ROS 2 form of a ROS 1 message; nested messages are referred to by name.

    Raises UnknownTypeError if a nested type is missing, DefinitionError for what ROS 2 cannot express.
    """
    dependencies(spec, registry.message)
    fields = tuple(_field(spec, field) for field in spec.fields)
    first_of: dict[str, str] = {}
    for old, new in zip(spec.fields, fields, strict=True):
        if (other := first_of.setdefault(new.name, old.name)) != old.name:
            raise DefinitionError(
                f"the fields {other!r} and {old.name!r} would both be {new.name!r} in ROS 2;"
                " write a ROS 2 definition of the type, and give its folder with --msg-path DIR",
                file=spec.full_name,
            )
    constants = tuple(each for constant in spec.constants if (each := _constant(constant)) is not None)
    return Ros2Message(spec.package, "msg", spec.name, fields, constants)


def ros2_field_name(name: str) -> str:
    """Return the ROS 2 name of a ROS 1 field: `D` -> `d`, `frameId` -> `frame_id`; legal names stay."""
    if is_field_name(name):
        return name
    words = _BEFORE_CAPITALS.sub("_", name).lower().split("_")
    return "_".join(word for word in words if word)


def _field(spec: MessageSpec, field: Field) -> Ros2Field:
    old = field.type
    if old.is_array and old.length == 0:
        raise DefinitionError(
            f"ROS 2 has no arrays of length 0, such as the field {field.name!r}; write a ROS 2 definition "
            "of the type, and give its folder with --msg-path DIR",
            file=spec.full_name,
        )
    base = _RENAMED.get(old.base, old.base)
    if base == old.base and base not in PRIMITIVE_TYPES:
        package, _, name = base.partition("/")
        base = f"{package}/msg/{name}"
    return Ros2Field(Ros2Type(base, is_array=old.is_array, length=old.length), ros2_field_name(field.name))


def _constant(constant: Constant) -> Ros2Constant | None:
    """Return the constant in ROS 2's spelling, or None if ROS 2 cannot express it."""
    name = "_".join(word for word in constant.name.upper().split("_") if word)
    if not is_constant_name(name):
        return None
    low, high = INTEGER_RANGES.get(constant.type, (None, None))
    value = constant.value
    if isinstance(value, int) and low is not None and high is not None and not low <= value <= high:
        # byte is signed in ROS 1 only.
        return Ros2Constant("int8", name, value)
    return Ros2Constant(constant.type, name, value)
