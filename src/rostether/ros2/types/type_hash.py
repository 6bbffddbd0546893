"""The type hash of ROS 2 (REP-2011, RIHS01), which endpoints compare when they connect.

It is the SHA-256 of the descriptions of a type and its nested types, in the JSON format of rcl. Field names
and types count; comments, constants and defaults do not.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from typing import Any, Protocol

from rostether.errors import DefinitionError
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import Ros2Field, Ros2Message, Ros2Service, Ros2Type
from rostether.msgdef.ros2.to_ros1 import MessageSource

TYPE_HASH_NOT_SUPPORTED = "TypeHashNotSupported"
PREFIX = "RIHS01_"

_DISTROS_WITHOUT_HASHES = frozenset({"foxy", "galactic", "humble"})
_NESTED_TYPE = 1
_NAME_PARTS = 3
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
    "char": 3,  # `char` in .msg files is a uint8; 13 is the `char` of IDL
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
_BOUNDED_STRING_IDS = {"string": 21, "wstring": 22}
_FIXED_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144
_BASES = {number: name for name, number in _TYPE_IDS.items() if name != "char"}
_STRING_BASES = {number: name for name, number in _BOUNDED_STRING_IDS.items()}
_KINDS_OF_ARRAYS = (0, _FIXED_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE)
_MEMBER_OF_EMPTY = "structure_needs_at_least_one_member"
_EVENT_INFO = "service_msgs/msg/ServiceEventInfo"


class HashSource(MessageSource, Protocol):
    """Definitions of one distribution."""

    @property
    def distro(self) -> str:
        """The distribution's name."""


def message_hash(message: Ros2Message, definitions: HashSource) -> str:
    """Return `RIHS01_` and 64 digits, or `TypeHashNotSupported` for a distribution that has no hashes.

    Raises UnknownTypeError, DefinitionError for nested types.
    """
    if definitions.distro in _DISTROS_WITHOUT_HASHES:
        return TYPE_HASH_NOT_SUPPORTED
    return rihs01(message, definitions.message)


def service_hash(service: Ros2Service, definitions: HashSource) -> str:
    """Return a service's hash. Raises the same errors as `message_hash`."""
    if definitions.distro in _DISTROS_WITHOUT_HASHES:
        return TYPE_HASH_NOT_SUPPORTED
    whole, *below = service_messages(service)
    parts = {each.full_name: each for each in below}
    return rihs01(whole, lambda name: parts.get(name) or definitions.message(name))


def service_messages(service: Ros2Service) -> tuple[Ros2Message, ...]:
    """Return the message that represents a service, then its request, response and event message."""
    event = event_message(service)
    members = {
        "request_message": service.request,
        "response_message": service.response,
        "event_message": event,
    }
    fields = tuple(Ros2Field(Ros2Type(each.full_name), name) for name, each in members.items())
    whole = Ros2Message(service.package, service.kind, service.name, fields)
    return whole, service.request, service.response, event


def rihs01(message: Ros2Message, lookup: Callable[[str], Ros2Message]) -> str:
    """Return a message's hash, regardless of the distribution; `lookup` returns nested messages.

    Raises the same errors as `message_hash`.
    """
    below = sorted(dependencies(message, lookup), key=lambda each: each.full_name)
    text = json.dumps(
        {
            "type_description": describe(message),
            "referenced_type_descriptions": [describe(each) for each in below],
        },
        # The text is hashed: rcl writes it with exactly these separators.
        separators=(", ", ": "),
    )
    return PREFIX + hashlib.sha256(text.encode()).hexdigest()


def described_message(name: str, fields: Iterable[Any]) -> Ros2Message:
    """Return a message of a type description: `fields` are type_description_interfaces/Field.

    Raises DefinitionError for an invalid name, and for types that .msg files do not support.
    """
    parts = name.split("/")
    if len(parts) != _NAME_PARTS:
        raise DefinitionError(f"{name!r:.80} is not the name of a type")
    described = tuple(Ros2Field(_described_type(field.type), field.name) for field in fields)
    if [field.name for field in described] == [_MEMBER_OF_EMPTY]:
        described = ()
    package, kind, short_name = parts
    return Ros2Message(package, kind, short_name, described)


def event_message(service: Ros2Service) -> Ros2Message:
    """Return the message that reports a service's calls, which rosidl adds to every service."""
    return Ros2Message(
        service.package,
        service.kind,
        f"{service.name}_Event",
        (
            Ros2Field(Ros2Type(_EVENT_INFO), "info"),
            Ros2Field(Ros2Type(service.request.full_name, is_array=True, bound=1), "request"),
            Ros2Field(Ros2Type(service.response.full_name, is_array=True, bound=1), "response"),
        ),
    )


def describe(message: Ros2Message) -> dict[str, Any]:
    """Return the fields of a message's type_description_interfaces/IndividualTypeDescription."""
    fields = [{"name": field.name, "type": _describe_type(field.type)} for field in message.fields]
    if not fields:
        # A struct in IDL cannot be empty: rosidl adds this member.
        empty = Ros2Type("uint8")
        fields = [{"name": _MEMBER_OF_EMPTY, "type": _describe_type(empty)}]
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


def _described_type(described: Any) -> Ros2Type:
    array = described.type_id // _FIXED_ARRAY
    type_id = described.type_id % _FIXED_ARRAY
    base = described.nested_type_name if type_id == _NESTED_TYPE else _BASES.get(type_id)
    string_bound = None
    if type_id in _STRING_BASES:
        base, string_bound = _STRING_BASES[type_id], described.string_capacity
    if base is None or array >= len(_KINDS_OF_ARRAYS):
        raise DefinitionError(f"a field has the type {described.type_id}, which .msg files do not support")
    kind = _KINDS_OF_ARRAYS[array]
    return Ros2Type(
        base,
        is_array=array > 0,
        length=described.capacity if kind == _FIXED_ARRAY else None,
        bound=described.capacity if kind == _BOUNDED_SEQUENCE else None,
        string_bound=string_bound,
    )
