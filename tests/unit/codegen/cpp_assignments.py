"""C++ statements that set the members of a message to the values of a Python message, like a sketch."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from rostether.codegen.cpp_literals import float32_literal, float64_literal, integer_literal, string_literal
from rostether.codegen.cpp_names import name_members, qualified_class
from rostether.msgdef.registry import Registry
from rostether.msgdef.spec import Field, MessageSpec

_NUMBERS = {"bool": "bool", "byte": "int8_t", "char": "uint8_t", "float32": "float", "float64": "double"}


class Assignments:
    """Writes statements; each array gets separate storage."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._numbers = itertools.count()

    def body(self, spec: MessageSpec, message: Any) -> str:
        """Return the statements for the variable `message`."""
        lines = self._message("message", spec, message)
        return "".join(f"  {line}\n" for line in lines) or "  (void)message;\n"

    def _message(self, target: str, spec: MessageSpec, value: Any) -> Iterator[str]:
        for field, name in zip(spec.fields, name_members(spec).fields, strict=True):
            yield from self._field(f"{target}.{name}", field, getattr(value, field.name))

    def _field(self, target: str, field: Field, value: Any) -> Iterator[str]:
        base = field.type.base
        if not field.type.is_array:
            yield from self._one(target, base, value)
            return
        array = target
        if field.type.length is None:
            array = f"array{next(self._numbers)}"
            yield f"static {self._element_type(base)} {array}[{len(value) + 1}];"
            yield f"{target} = {array};"
            yield f"{target}_length = {len(value)};"
        for position, each in enumerate(value):
            yield from self._one(f"{array}[{position}]", base, each, of_array=True)

    def _one(self, target: str, base: str, value: Any, *, of_array: bool = False) -> Iterator[str]:
        if base == "string":
            text = string_literal(value)
            yield f"{target} = {f'const_cast<char*>({text})' if of_array else text};"
        elif base in ("time", "duration"):
            yield f"{target}.sec = {integer_literal(value.secs)};"
            yield f"{target}.nsec = {integer_literal(value.nsecs)};"
        elif base in ("float32", "float64"):
            yield f"{target} = {float32_literal(value) if base == 'float32' else float64_literal(value)};"
        elif "/" in base:
            yield from self._message(target, self._registry.message(base), value)
        else:
            yield f"{target} = {integer_literal(int(value))};"

    @staticmethod
    def _element_type(base: str) -> str:
        if base == "string":
            return "char*"
        if base in ("time", "duration"):
            return f"ros::{base.capitalize()}"
        return qualified_class(base) if "/" in base else _NUMBERS.get(base, f"{base}_t")
