"""The hash by which the ends of a ROS 2 connection know that they mean the same type (REP-2011, RIHS01).

SHA-256 of the type's description, with those of all types below it, in JSON as rcl writes it. Field names and
types count; comments, constants and defaults do not.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any, Protocol

from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Field, Ros2Message, Ros2Service, Ros2Type

TYPE_HASH_NOT_SUPPORTED = "TypeHashNotSupported"
PREFIX = "RIHS01_"

_DISTROS_WITHOUT_HASHES = frozenset({"foxy", "galactic", "humble"})
_NESTED_TYPE = 1
# type_description_interfaces/msg/FieldType
_TYPE_IDS = {
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "char": 3,  # the char of .msg texts is a uint8; 13 is that of IDL
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
_BOUNDED_STRING_IDS = {"string": 21, "wstring": 22}
_FIXED_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144
_EVENT_INFO = "service_msgs/msg/ServiceEventInfo"


class MessageSource(Protocol):
    """What finds the messages below a type, as `Ros2Definitions` does."""

    def message(self, name: str) -> Ros2Message:
        """Return a message by `package/msg/Name`."""


class HashSource(MessageSource, Protocol):
    """Definitions that know of which distribution they are."""

    @property
    def distro(self) -> str:
        """The distribution's name."""


def message_hash(message: Ros2Message, definitions: HashSource) -> str:
    """Return `RIHS01_` and 64 digits, or `TypeHashNotSupported` for a distribution that has no hashes.

    Raises UnknownTypeError, DefinitionError for the types below.
    """
    if definitions.distro in _DISTROS_WITHOUT_HASHES:
        return TYPE_HASH_NOT_SUPPORTED
    return rihs01(message, definitions)


def service_hash(service: Ros2Service, definitions: HashSource) -> str:
    """Return a service's hash. Raises the same errors as `message_hash`."""
    if definitions.distro in _DISTROS_WITHOUT_HASHES:
        return TYPE_HASH_NOT_SUPPORTED
    event = event_message(service)
    halves = {each.full_name: each for each in (service.request, service.response, event)}
    members = {
        "request_message": service.request,
        "response_message": service.response,
        "event_message": event,
    }
    whole = Ros2Message(
        service.package,
        "srv",
        service.name,
        tuple(Ros2Field(Ros2Type(each.full_name), name) for name, each in members.items()),
    )
    return rihs01(whole, _WithHalves(halves, definitions))


def rihs01(message: Ros2Message, definitions: MessageSource) -> str:
    """Return a message's hash whatever the distribution. Raises as `message_hash` does."""
    below = sorted(dependencies(message, definitions.message), key=lambda each: each.full_name)
    text = json.dumps(
        {
            "type_description": _describe(message),
            "referenced_type_descriptions": [_describe(each) for each in below],
        },
        # The text is hashed: rcl writes it with exactly these separators.
        separators=(", ", ": "),
    )
    return PREFIX + hashlib.sha256(text.encode()).hexdigest()


def event_message(service: Ros2Service) -> Ros2Message:
    """Return the message that reports a service's calls, which rosidl adds to every service."""
    return Ros2Message(
        service.package,
        "srv",
        f"{service.name}_Event",
        (
            Ros2Field(Ros2Type(_EVENT_INFO), "info"),
            Ros2Field(Ros2Type(service.request.full_name, is_array=True, bound=1), "request"),
            Ros2Field(Ros2Type(service.response.full_name, is_array=True, bound=1), "response"),
        ),
    )


class _WithHalves:
    """Definitions in which the parts of one service can be looked up as well."""

    def __init__(self, halves: dict[str, Ros2Message], definitions: MessageSource) -> None:
        self._halves = halves
        self._definitions = definitions

    def message(self, name: str) -> Ros2Message:
        return self._halves.get(name) or self._definitions.message(name)


def _describe(message: Ros2Message) -> dict[str, Any]:
    fields = [{"name": field.name, "type": _describe_type(field.type)} for field in message.fields]
    if not fields:
        # A struct of IDL cannot be empty: rosidl gives it this member.
        empty = Ros2Type("uint8")
        fields = [{"name": "structure_needs_at_least_one_member", "type": _describe_type(empty)}]
    return {"type_name": message.full_name, "fields": fields}


def _describe_type(field_type: Ros2Type) -> dict[str, Any]:
    base = field_type.base
    if base not in PRIMITIVE_TYPES:
        type_id = _NESTED_TYPE
    elif field_type.string_bound is not None:
        type_id = _BOUNDED_STRING_IDS[base]
    else:
        type_id = _TYPE_IDS[base]
    if field_type.is_array:
        if field_type.length is not None:
            type_id += _FIXED_ARRAY
        else:
            type_id += _SEQUENCE if field_type.bound is None else _BOUNDED_SEQUENCE
    return {
        "type_id": type_id,
        "capacity": field_type.length or field_type.bound or 0,
        "string_capacity": field_type.string_bound or 0,
        "nested_type_name": "" if base in PRIMITIVE_TYPES else base,
    }
