"""Reads ROS 2 .msg, .srv and .action texts: lines of `type name [default]` or `type NAME=value`.

Accepts and refuses the same texts as rosidl, with two exceptions: indented declarations are accepted, and
types that its code generators would refuse (`time`, the request of a service as a field) are refused here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from rostether.errors import DefinitionError
from rostether.msgdef.parse_msg import MAX_ARRAY_LENGTH, MAX_FIELDS, MAX_TEXT_CHARACTERS
from rostether.msgdef.ros2.literals import read_default, read_literal
from rostether.msgdef.ros2.primitives import PRIMITIVE_TYPES, STRING_TYPES
from rostether.msgdef.ros2.spec import (
    ConstantValue,
    DefaultValue,
    Ros2Action,
    Ros2Constant,
    Ros2Field,
    Ros2Message,
    Ros2Service,
    Ros2Type,
)
from rostether.msgdef.source_line import SourceLine
from rostether.names.graph_name import quote

SECTION_MARK = "---"
REQUEST_SUFFIX = "_Request"
RESPONSE_SUFFIX = "_Response"

# The names of packages and fields.
_LOWER_NAME = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
_TYPE_NAME = re.compile(r"[A-Z][A-Za-z0-9]*")
# Equivalent to rosidl's [A-Z]([A-Z0-9_]?[A-Z0-9]+)*, but in linear time.
_CONSTANT_NAME = re.compile(r"(?!.*__)(?!.*_$)[A-Z][A-Z0-9_]*")
_TYPE = re.compile(r"([A-Za-z][\w/]*)(?:<=([0-9]+))?(\[(?:(<=)?([0-9]+))?\])?", re.ASCII)

# A number with more digits is certainly too large; Python would take long to read it.
_MAX_COUNT_DIGITS = 19
_ROS1_TYPES = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}


def is_field_name(name: str) -> bool:
    """Return whether a field may have this name."""
    return _LOWER_NAME.fullmatch(name) is not None


def is_constant_name(name: str) -> bool:
    """Return whether a constant may have this name."""
    return _CONSTANT_NAME.fullmatch(name) is not None


def parse_message(
    text: str, *, package: str, name: str, kind: str = "msg", file: str = "", first_line: int = 1
) -> Ros2Message:
    """Parse a definition. Raises DefinitionError with file, line and column of the first error.

    Types without a package belong to `package`. `first_line` is the number of the text's first line in
    its file.
    """
    file = file or f"{package}/{kind}/{name}"
    if len(text) > MAX_TEXT_CHARACTERS:
        raise DefinitionError(
            f"the definition is longer than {MAX_TEXT_CHARACTERS} characters; split it", file=file
        )
    fields: list[Ros2Field] = []
    constants: list[Ros2Constant] = []
    names: set[str] = set()
    for number, line in enumerate(text.split("\n"), first_line):
        declaration = line.partition("#")[0].replace("\t", " ").rstrip()
        if not declaration.strip():
            continue
        source = SourceLine(file, number, declaration, declaration)
        type_text, _, rest = declaration.strip().partition(" ")
        rest = rest.lstrip()
        if not rest:
            source.fail(f"{quote(type_text)} is not 'type name' or 'type NAME=value'")
        if "=" in rest:
            constants.append(_parse_constant(source, type_text, rest))
            continue
        field = _parse_field(source, type_text, rest, package)
        if field.name in names:
            source.fail(f"the field {field.name!r} is declared twice", field.name)
        if len(fields) == MAX_FIELDS:
            source.fail(f"a message can have at most {MAX_FIELDS} fields; use arrays or nested messages")
        names.add(field.name)
        fields.append(field)
    return Ros2Message(package, kind, name, tuple(fields), tuple(constants))


def parse_service(text: str, *, package: str, name: str, file: str = "") -> Ros2Service:
    """Parse a definition: the request, one line `---`, the response.

    Raises DefinitionError with file, line and column of the first error.
    """
    names = [name + REQUEST_SUFFIX, name + RESPONSE_SUFFIX]
    request, response = _parse_sections(
        text, names, package=package, kind="srv", file=file or f"{package}/srv/{name}"
    )
    return Ros2Service(package, name, request, response)


def parse_action(text: str, *, package: str, name: str, file: str = "") -> Ros2Action:
    """Parse a definition: goal, result and feedback, with a line `---` between them.

    Raises DefinitionError, as `parse_service` does.
    """
    names = [f"{name}_Goal", f"{name}_Result", f"{name}_Feedback"]
    parts = _parse_sections(
        text, names, package=package, kind="action", file=file or f"{package}/action/{name}"
    )
    return Ros2Action(package, name, *parts)


def _parse_sections(
    text: str, names: Sequence[str], *, package: str, kind: str, file: str
) -> list[Ros2Message]:
    lines = text.split("\n")
    marks = [index for index, line in enumerate(lines) if line.rstrip() == SECTION_MARK]
    wanted = len(names) - 1
    if len(marks) != wanted:
        line = marks[wanted] + 1 if len(marks) > wanted else 0
        between = " and ".join(each.rpartition("_")[2].lower() for each in names)
        raise DefinitionError(
            f"the number of {SECTION_MARK!r} lines between {between} is {len(marks)}, not {wanted}",
            file=file,
            line=line,
            column=1 if line else 0,
        )
    starts = [0, *(mark + 1 for mark in marks)]
    ends = [*marks, len(lines)]
    return [
        parse_message(
            "\n".join(lines[start:end]),
            package=package,
            name=name,
            kind=kind,
            file=file,
            first_line=start + 1,
        )
        for name, start, end in zip(names, starts, ends, strict=True)
    ]


def _parse_field(line: SourceLine, type_text: str, rest: str, package: str) -> Ros2Field:
    field_type = _parse_type(line, type_text, package)
    name, _, default_text = rest.partition(" ")
    if not is_field_name(name):
        line.fail(
            f"{quote(name)} is not a field name: a lowercase letter, then lowercase letters, digits and"
            " single '_'",
            name,
        )
    default_text = default_text.strip()
    if not default_text:
        return Ros2Field(field_type, name)
    if field_type.base not in PRIMITIVE_TYPES:
        line.fail(f"{name}: only fields of built-in types can have a default", default_text)
    default: DefaultValue
    try:
        default = read_default(field_type, default_text)
    except ValueError as error:
        line.fail(f"{name}: {error}", default_text)
    return Ros2Field(field_type, name, default)


def _parse_type(line: SourceLine, text: str, package: str) -> Ros2Type:
    found = _TYPE.fullmatch(text)
    if found is None:
        line.fail(
            f"{quote(text)} is not a type such as uint8, string<=10, float32[3], int8[<=5] or package/Name",
            text,
        )
    base, string_bound, brackets, at_most, count_text = found.groups()
    if string_bound is not None and base not in STRING_TYPES:
        line.fail(f"{quote(text)}: only string and wstring can have a bound", text)
    if base not in PRIMITIVE_TYPES:
        base = _full_name(line, base, package)
    count = _count(line, count_text, text)
    return Ros2Type(
        base,
        is_array=brackets is not None,
        length=None if at_most else count,
        bound=count if at_most else None,
        string_bound=_count(line, string_bound, text),
    )


def _full_name(line: SourceLine, text: str, package: str) -> str:
    if text in _ROS1_TYPES:
        line.fail(f"{text!r} is a type of ROS 1; ROS 2 has {_ROS1_TYPES[text]}", text)
    owner, slash, name = text.rpartition("/")
    if slash and not _LOWER_NAME.fullmatch(owner):
        line.fail(
            f"{quote(text)} is not 'package/Name'; packages are lowercase letters, digits, single '_'", text
        )
    if not _TYPE_NAME.fullmatch(name):
        line.fail(
            f"{quote(name)} is not a built-in type or a message name (an uppercase letter, then letters"
            " and digits)",
            text,
        )
    return f"{owner or package}/msg/{name}"


def _count(line: SourceLine, digits: str | None, type_text: str) -> int | None:
    if digits is None:
        return None
    count = int(digits) if len(digits) <= _MAX_COUNT_DIGITS else MAX_ARRAY_LENGTH + 1
    if count == 0:
        line.fail(f"{quote(type_text)}: a length or bound must be at least 1", type_text)
    if count > MAX_ARRAY_LENGTH:
        line.fail(f"{quote(type_text)}: a length or bound can be at most {MAX_ARRAY_LENGTH}", type_text)
    return count


def _parse_constant(line: SourceLine, type_text: str, rest: str) -> Ros2Constant:
    if type_text not in PRIMITIVE_TYPES:
        line.fail(f"{quote(type_text)} cannot be the type of a constant", type_text)
    name, _, value_text = rest.partition("=")
    name, value_text = name.rstrip(), value_text.strip()
    if not is_constant_name(name):
        line.fail(
            f"{quote(name)} is not a constant's name: an uppercase letter, then uppercase letters, digits and"
            " single '_'",
            name or "=",
        )
    value: ConstantValue
    try:
        value = read_literal(type_text, value_text)
    except ValueError as error:
        line.fail(f"{name}: {error}", value_text)
    return Ros2Constant(type_text, name, value)
