"""Types in the form of rosapi: each with its fields, followed by its nested types in order of first use.

A field's `fieldarraylen` is -1 for a single value, 0 for an array of any length, otherwise its length; its
example is a zero, `[]` or `{}` (source: behaviour of rosapi).
"""

from __future__ import annotations

from typing import Any, Final

from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import Field, MessageSpec

# The limit of nested types; real types have about 30, and definitions also come from peers.
MAX_TYPES: Final = 512

_STAMPS: Final = ("time", "duration")
_EXAMPLES: Final = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}


def message_details(registry: Registry, name: str) -> list[dict[str, Any]]:
    """Return a message and all below it as rosapi/TypeDef. Raises UnknownTypeError, DefinitionError."""
    details: list[dict[str, Any]] = []
    waiting = [name]
    seen: set[str] = set()
    while waiting and len(details) < MAX_TYPES:
        each = waiting.pop(0)
        if each in seen:
            continue
        seen.add(each)
        if each in _STAMPS:
            details.append(_stamp_details(each))
            continue
        spec = registry.message(each)
        details.append(_details(spec))
        # Depth first, as in rosapi.
        waiting[:0] = [field.type.base for field in spec.fields if _has_details(field)]
    return details


def _has_details(field: Field) -> bool:
    return "/" in field.type.base or field.type.base in _STAMPS


def _details(spec: MessageSpec) -> dict[str, Any]:
    return {
        "type": spec.full_name,
        "fieldnames": [field.name for field in spec.fields],
        "fieldtypes": [field.type.base for field in spec.fields],
        "fieldarraylen": [_array_length(field) for field in spec.fields],
        "examples": [_example(field) for field in spec.fields],
        "constnames": [constant.name for constant in spec.constants],
        "constvalues": [str(constant.value) for constant in spec.constants],
    }


def _stamp_details(name: str) -> dict[str, Any]:
    return {
        "type": name,
        "fieldnames": ["secs", "nsecs"],
        "fieldtypes": ["int32", "int32"],
        "fieldarraylen": [-1, -1],
        "examples": ["0", "0"],
        "constnames": [],
        "constvalues": [],
    }


def _array_length(field: Field) -> int:
    return (field.type.length or 0) if field.type.is_array else -1


def _example(field: Field) -> str:
    if field.type.is_array:
        return "[]"
    return "{}" if _has_details(field) else _EXAMPLES.get(field.type.base, "0")
