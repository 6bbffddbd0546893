"""A ROS 2 definition in the form of ROS 1: the same fields, for the ROS 1 codec.

`package/msg/Name` becomes `package/Name`, and `package/srv/Name_Request` becomes `package/NameRequest`. byte
and char are uint8, as in ROS 2, and wstring is string; bounds and defaults are omitted. builtin_interfaces'
Time and Duration are messages of two numbers, and std_msgs/Header has no seq.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.ros2.parse import REQUEST_SUFFIX, RESPONSE_SUFFIX
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Constant, Ros2Field, Ros2Message, Ros2Service
from rostether.msgdef.spec import Constant, Field, FieldType, MessageSpec

_BASES = {"byte": "uint8", "char": "uint8", "wstring": "string"}


class MessageSource(Protocol):
    """Finds the nested messages of a type, like `Ros2Definitions`."""

    def message(self, name: str) -> Ros2Message:
        """Return a message by `package/msg/Name`."""


def as_ros1_specs(message: Ros2Message, definitions: MessageSource) -> list[MessageSpec]:
    """Return the message in the form of ROS 1, then all nested messages in the order of first use.

    Raises UnknownTypeError, DefinitionError.
    """
    return [_expressed(each) for each in (message, *dependencies(message, definitions.message))]


def ros1_name(name: str) -> str:
    """Return the ROS 1 form of a ROS 2 name: `sensor_msgs/msg/Imu` -> `sensor_msgs/Imu`."""
    package, _, short_name = name.partition("/")
    kind, _, short_name = short_name.partition("/")
    return f"{package}/{short_name.replace('_', '') if kind == 'srv' else short_name}"


def _expressed(message: Ros2Message) -> MessageSpec:
    fields = tuple(_field(field) for field in message.fields)
    constants = tuple(_constant(constant) for constant in message.constants)
    lines = [f"{constant.type} {constant.name}={constant.text}" for constant in constants]
    lines += [f"{field.type} {field.name}" for field in fields]
    package, _, name = ros1_name(message.full_name).partition("/")
    return MessageSpec(package, name, fields, constants, "".join(f"{line}\n" for line in lines))


def _field(field: Ros2Field) -> Field:
    old = field.type
    base = _BASES.get(old.base, old.base) if old.base in PRIMITIVE_TYPES else ros1_name(old.base)
    length_text = "" if old.length is None else str(old.length)
    return Field(FieldType(base, old.is_array, old.length, length_text), field.name)


def _constant(constant: Ros2Constant) -> Constant:
    base = _BASES.get(constant.type, constant.type)
    value = constant.value
    # A constant of ROS 1 ends with its line, without surrounding blanks.
    if isinstance(value, str):
        value = text = " ".join(value.split())
    else:
        text = str(int(value)) if isinstance(value, bool) else repr(value)
    return Constant(base, constant.name, value, text)


def joined_services(messages: Mapping[str, Ros2Message]) -> Iterator[Ros2Service]:
    """Yield the services whose request and response are both among the messages, keyed by full name."""
    for name, request in messages.items():
        service = name.removesuffix(REQUEST_SUFFIX)
        response = messages.get(service + RESPONSE_SUFFIX)
        if service != name and request.kind in ("srv", "action") and response is not None:
            short_name = request.name.removesuffix(REQUEST_SUFFIX)
            yield Ros2Service(request.package, short_name, request, response, request.kind)
