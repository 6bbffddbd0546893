"""The constants of a message: integers as enumerators, floats and strings as static constants.

C++11 wants a static constant that is used by reference defined once in the program. A header cannot do that
for a class, but it can for a class template: floats and strings stand in one, from which the message derives.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rostether.codegen.cpp_literals import (
    float32_literal,
    float64_literal,
    integer_literal,
    narrow_double_literal,
    string_literal,
)
from rostether.codegen.cpp_names import NamedConstant, constants_class
from rostether.msgdef.spec import Constant

_STATIC_TYPES = {"float32": "float", "float64": "double", "string": "const char*"}


def enumerators(constants: Iterable[NamedConstant]) -> Iterator[str]:
    """Yield the declarations of the integer and bool constants."""
    for each in constants:
        if not is_static(each):
            yield f"enum {{ {each.name} = {integer_literal(int(each.constant.value))} }};"
            if each.alias is not None:
                yield f"enum {{ {each.alias} = {each.name} }};"


def is_static(constant: NamedConstant) -> bool:
    """Return whether a constant is a float or a string; these are in the class template."""
    return constant.constant.type in _STATIC_TYPES


def static_constants(cpp_class: str, constants: Iterable[NamedConstant]) -> Iterator[str]:
    """Yield the class template of a message's float and string constants, and their definitions."""
    holder = constants_class(cpp_class)
    statics = [each for each in constants if is_static(each)]
    yield "template <class T>"
    yield f"struct {holder} {{"
    for each in statics:
        yield from _declaration(each.constant, each.name)
        if each.alias is not None:
            yield f"  static constexpr {_STATIC_TYPES[each.constant.type]} {each.alias} = {each.name};"
    yield "};"
    for each in statics:
        for name in filter(None, (each.name, each.alias)):
            yield "template <class T>"
            yield f"constexpr {_STATIC_TYPES[each.constant.type]} {holder}<T>::{name};"


def _declaration(constant: Constant, name: str) -> Iterator[str]:
    start = f"  static constexpr {_STATIC_TYPES[constant.type]} {name} = "
    if constant.type == "string":
        yield f"{start}{string_literal(str(constant.value))};"
        return
    value = float(constant.value)
    if constant.type == "float32":
        yield f"{start}{float32_literal(value)};"
        return
    narrow = narrow_double_literal(value)
    if narrow is not None:
        yield "#if defined(__SIZEOF_DOUBLE__) && __SIZEOF_DOUBLE__ < 8"
        yield f"{start}{narrow};"
        yield "#else"
    yield f"{start}{float64_literal(value)};"
    if narrow is not None:
        yield "#endif"
