"""The class of one message, and the header that holds it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rostether.codegen.cpp_constants import enumerators, is_static, static_constants
from rostether.codegen.cpp_fields import field_lines
from rostether.codegen.cpp_header import header
from rostether.codegen.cpp_literals import string_literal
from rostether.codegen.cpp_names import MemberNames, class_name, constants_class, include_path, name_members
from rostether.codegen.cpp_types import is_message
from rostether.codegen.reserved_words import is_macro
from rostether.msgdef.spec import MessageSpec

_LINE_WIDTH = 110

# Maps the full name of a message to that of the type whose header has it: itself, or its service.
HeaderOf = Callable[[str], str]


def message_header(spec: MessageSpec, md5sum: str, header_of: HeaderOf = str) -> str:
    """Return the text of a message's header."""
    names = name_members(spec)
    classes = message_class(spec, names, type_name=spec.full_name, md5sum=md5sum)
    return header(spec.full_name, included_paths(spec, header_of), sheltered_names(names), classes)


def included_paths(spec: MessageSpec, header_of: HeaderOf) -> set[str]:
    """Return the headers of the messages that are fields."""
    types = {field.type.base for field in spec.fields if is_message(field.type.base)}
    return {include_path(header_of(each)) for each in types}


def sheltered_names(names: MemberNames) -> set[str]:
    """Return the members whose names may be macros: of a known platform, or constants in a sketch."""
    return {each.name for each in names.constants} | {name for name in names.fields if is_macro(name)}


def message_class(spec: MessageSpec, names: MemberNames, *, type_name: str, md5sum: str) -> Iterator[str]:
    """Yield the lines of a message's class; `type_name` and `md5sum` are announced to the host."""
    cpp_class = class_name(spec.name)
    parents = f"public ros::Message<{cpp_class}>"
    if any(map(is_static, names.constants)):
        yield from static_constants(cpp_class, names.constants)
        yield ""
        parents += f", public {constants_class(cpp_class)}<void>"
    fields = [field_lines(field, name) for field, name in zip(spec.fields, names.fields, strict=True)]
    yield f"class {cpp_class} : {parents} {{"
    yield " public:"
    parts = (
        enumerators(names.constants),
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
