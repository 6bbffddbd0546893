"""`msg show` and `srv show` of ROS 2 definitions, as `ros2 interface show` prints them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rostether.cli.msg.shown_definition import shown_definition
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES
from rostether.msgdef.ros2.spec import DefaultValue, Ros2Message, Ros2Service, Ros2Type
from rostether.ros2.types.native_registry import NativeRegistry, short_name
from rostether.ros2.types.type_hash import message_hash, service_hash

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry


def shown(registry: Registry, group: str, name: str) -> str:
    """Return the fields of a message, or of all parts of a service or action, each type's fields below it."""
    native = _native(registry)
    if group == "action":
        halves = native.definitions.action(name).action.parts
    else:
        halves = _found(registry, group, name).parts
    texts = (shown_definition(half, native.ros2_message, _lines(native, half, "")) for half in halves)
    return "\n---\n".join(text.removesuffix("\n") for text in texts)


def type_hash(registry: Registry, group: str, name: str) -> str:
    """Return the hash that both ends of a topic or service must agree on."""
    found = _found(registry, group, name)
    source = _native(registry).source
    if isinstance(found, Ros2Message):
        return message_hash(found, source)
    return service_hash(found, source)


def record(registry: Registry, group: str, name: str) -> dict[str, Any]:
    """Return a definition for `--json`."""
    found = _found(registry, group, name)
    base = {"type": found.full_name, "type_hash": type_hash(registry, group, name)}
    if isinstance(found, Ros2Message):
        return {**base, **_described(found)}
    return {**base, "request": _described(found.request), "response": _described(found.response)}


def _native(registry: Registry) -> NativeRegistry:
    assert isinstance(registry, NativeRegistry)
    return registry


def _found(registry: Registry, group: str, name: str) -> Ros2Message | Ros2Service:
    native = _native(registry)
    return native.ros2_message(name) if group == "msg" else native.ros2_service(name)


def _described(message: Ros2Message) -> dict[str, Any]:
    return {
        "constants": [{"type": c.type, "name": c.name, "value": c.value} for c in message.constants],
        "fields": [
            {"type": str(field.type), "name": field.name, "default": field.default}
            for field in message.fields
        ],
    }


def _lines(registry: NativeRegistry, message: Ros2Message, indent: str) -> Iterator[str]:
    for constant in message.constants:
        yield f"{indent}{constant.type} {constant.name}={_text(constant.value)}"
    for field in message.fields:
        default = "" if field.default is None else f" {_text(field.default)}"
        yield f"{indent}{_type_text(field.type, message.package)} {field.name}{default}"
        if field.type.base not in PRIMITIVE_TYPES:
            yield from _lines(registry, registry.ros2_message(field.type.base), f"{indent}\t")


def _type_text(field_type: Ros2Type, package: str) -> str:
    """Return a type as its package's own text has it: short, and without the package where it is the same."""
    text = str(field_type)
    if field_type.base in PRIMITIVE_TYPES:
        return text
    short = short_name(field_type.base)
    return text.replace(field_type.base, short.removeprefix(f"{package}/"), 1)


def _text(value: DefaultValue) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and value.is_integer():
        # As people write it.
        return str(int(value))
    return f'"{value}"' if isinstance(value, str) else str(value)
