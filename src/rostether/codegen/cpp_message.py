"""Generates the class of one message."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec import Struct

from rostether.codegen.cpp_literals import (
    float32_literal,
    float64_literal,
    integer_literal,
    narrow_double_literal,
    string_literal,
)
from rostether.codegen.cpp_names import (
    MemberNames,
    NamedConstant,
    class_name,
    constants_class,
    is_variable_array,
    qualified_class,
)
from rostether.codegen.reserved_words import is_macro
from rostether.msgdef.primitives import PRIMITIVE_TYPES
from rostether.msgdef.spec import Constant, Field, MessageSpec

_LINE_WIDTH = 110

_STATIC_TYPES = {"float32": "float", "float64": "double", "string": "const char*"}

# Sketches assign arrays of float and of double to a float64[]; this class accepts both.
_SEQUENCE_POINTERS = {"float64": "ros::Float64Pointer"}
# The elements of these sequences are not aligned in the receive buffer.
_UNALIGNED_ELEMENTS = {"int64": "ros::unaligned_int64", "uint64": "ros::unaligned_uint64"}

_PRIMITIVES = {
    "bool": "bool",
    # The two old names: byte is signed, char is not, unlike in C.
    "byte": "int8_t",
    "char": "uint8_t",
    **{f"{sign}int{bits}": f"{sign}int{bits}_t" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    "float32": "float",
    "float64": "double",
    "string": "const char*",
    "time": "ros::Time",
    "duration": "ros::Duration",
}
_ZEROS = {"bool": "false", "string": '""', "time": "", "duration": ""}


def included_messages(spec: MessageSpec) -> set[str]:
    """Return the full names of the messages that are fields."""
    return {field.type.base for field in spec.fields if is_message(field.type.base)}


def possible_macros(names: MemberNames) -> set[str]:
    """Return the members whose names may also be macros of a platform or a sketch."""
    return {each.name for each in names.constants} | {name for name in names.fields if is_macro(name)}


def message_class(spec: MessageSpec, names: MemberNames, *, type_name: str, md5sum: str) -> Iterator[str]:
    """Yield the lines of a message's class; `type_name` and `md5sum` are announced to the host."""
    cpp_class = class_name(spec.name)
    parents = f"public ros::Message<{cpp_class}>"
    if any(map(is_static, names.constants)):
        yield from _static_constants(cpp_class, names.constants)
        yield ""
        parents += f", public {constants_class(cpp_class)}<void>"
    fields = [_field_lines(field, name) for field, name in zip(spec.fields, names.fields, strict=True)]
    yield f"class {cpp_class} : {parents} {{"
    yield " public:"
    parts = (
        _enumerators(names.constants),
        (line for field in fields for line in field.declarations),
        _constructor(cpp_class, [each for field in fields for each in field.initializers]),
        _field_list([field.archive_call for field in fields if field.archive_call]),
        [f"ROS_MESSAGE_TYPE({string_literal(type_name)}, {string_literal(md5sum)})"],
    )
    yield "\n\n".join("\n".join(f"  {line}" for line in lines) for part in parts if (lines := list(part)))
    yield "};"


def _constructor(cpp_class: str, initializers: list[str]) -> Iterator[str]:
    if not initializers:
        yield f"constexpr {cpp_class}() {{}}"
        return
    line = f"constexpr {cpp_class}() : {', '.join(initializers)} {{}}"
    if len(line) < _LINE_WIDTH:
        yield line
        return
    yield f"constexpr {cpp_class}()"
    for index, each in enumerate(initializers):
        yield f"    {',' if index else ':'} {each}"
    yield "{}"


def _field_list(calls: list[str]) -> Iterator[str]:
    yield "template <class Archive, class Self>"
    if not calls:
        yield "static void _fields(Archive&, Self&) {}"
        return
    yield "static void _fields(Archive& archive, Self& self) {"
    yield from (f"  {call}" for call in calls)
    yield "}"


def _enumerators(constants: Iterable[NamedConstant]) -> Iterator[str]:
    for each in constants:
        if not is_static(each):
            yield f"enum {{ {each.name} = {integer_literal(int(each.constant.value))} }};"
            if each.alias is not None:
                yield f"enum {{ {each.alias} = {each.name} }};"


def is_static(constant: NamedConstant) -> bool:
    """Return whether a constant is a float or a string; these are in the class template."""
    return constant.constant.type in _STATIC_TYPES


def _static_constants(cpp_class: str, constants: Iterable[NamedConstant]) -> Iterator[str]:
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


class _FieldLines(Struct, frozen=True):
    """Declarations, initializers (`name{value}`) and the call that passes the field to an archive."""

    declarations: tuple[str, ...]
    initializers: tuple[str, ...]
    archive_call: str


def _field_lines(field: Field, name: str) -> _FieldLines:
    if is_variable_array(field):
        return _sequence(field, name)
    if field.type.is_array:
        return _fixed_array(field, name)
    return _single_value(field, name)


def _single_value(field: Field, name: str) -> _FieldLines:
    base = field.type.base
    call = "message" if is_message(base) else "string" if base == "string" else "value"
    return _FieldLines(
        (f"typedef {_scalar_type(base)} _{name}_type;", f"_{name}_type {name};"),
        (f"{name}{{{'' if is_message(base) else _ZEROS.get(base, '0')}}}",),
        f"archive.{call}(self.{name});",
    )


def _fixed_array(field: Field, name: str) -> _FieldLines:
    if field.type.length == 0:
        # C++ has no arrays without elements, and there is nothing to send.
        return _FieldLines((f"// {name} has no elements.",), (), "")
    return _FieldLines(
        (f"{_element_type(field.type.base)} {name}[{field.type.length}];",),
        (f"{name}{{}}",),
        f"archive.fixed(self.{name});",
    )


def _sequence(field: Field, name: str) -> _FieldLines:
    base = field.type.base
    pointer = _SEQUENCE_POINTERS.get(base, f"_{name}_type*")
    call = "sequence64" if base in _UNALIGNED_ELEMENTS else "sequence"
    return _FieldLines(
        (
            f"ros::array_length {name}_length;",
            f"typedef {_UNALIGNED_ELEMENTS.get(base) or _element_type(base)} _{name}_type;",
            f"{pointer} {name};",
        ),
        (f"{name}_length{{0}}", f"{name}{{nullptr}}"),
        f"archive.{call}(self.{name}, self.{name}_length);",
    )


def is_message(base: str) -> bool:
    """Return whether a field's type is a message, not a primitive."""
    return base not in PRIMITIVE_TYPES


def _scalar_type(base: str) -> str:
    return _PRIMITIVES.get(base) or qualified_class(base)


def _element_type(base: str) -> str:
    return "char*" if base == "string" else _scalar_type(base)
