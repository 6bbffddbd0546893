"""Reads a .msg text: one declaration per line, `type name` or `type NAME=value`, comments after `#`.

Accepts and refuses the same texts as genmsg, with three exceptions. A constant whose name contains a blank is
refused, because no client library could compile it. The name of an indented string constant does not include
its type. Tabs separate words, as blanks do.
"""

from __future__ import annotations

import re

from rostether.errors import DefinitionError
from rostether.msgdef.primitives import CONSTANT_TYPES, INTEGER_RANGES, PRIMITIVE_TYPES
from rostether.msgdef.source_line import SourceLine
from rostether.msgdef.spec import Constant, ConstantValue, Field, FieldType, MessageSpec
from rostether.names.graph_name import quote

# Definitions also come from peers; the longest in use have about 20 KB.
MAX_TEXT_CHARACTERS = 1 << 18

# Each field becomes generated code; messages in use have at most about a hundred.
MAX_FIELDS = 4096

# A fixed array is part of every message, and no link carries more than 16 MB.
MAX_ARRAY_LENGTH = 1 << 24

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_CONSTANT_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_FIELD_TYPE = re.compile(r"([A-Za-z]\w*(?:/[A-Za-z]\w*)?)(\[([0-9]*)\])?", re.ASCII)
_HEADER = "Header"
_HEADER_FULL_NAME = "std_msgs/Header"
_BOOLS = {"True": True, "False": False, "1": True, "0": False}

# A bool constant may be any Python literal, but none needs to be long.
_MAX_BOOL_CHARACTERS = 100


def parse_message(text: str, *, package: str, name: str, file: str = "", first_line: int = 1) -> MessageSpec:
    """Parse a definition. Raises DefinitionError with file, line and column of the first error.

    Types without a package belong to `package`, and a plain `Header` is std_msgs/Header.
    `first_line` is the number of the text's first line in its file.
    """
    file = file or f"{package}/{name}"
    if len(text) > MAX_TEXT_CHARACTERS:
        raise DefinitionError(
            f"the definition is longer than {MAX_TEXT_CHARACTERS} characters; split it", file=file
        )
    fields: list[Field] = []
    constants: list[Constant] = []
    names: set[str] = set()
    for number, line in enumerate(text.split("\n"), first_line):
        declaration = line.partition("#")[0]
        if not declaration.strip():
            continue
        source = SourceLine(file, number, line, declaration)
        if "=" in declaration:
            constants.append(_parse_constant(source))
            continue
        field = _parse_field(source, package)
        if field.name in names:
            source.fail(f"the field {field.name!r} is declared twice", field.name)
        if len(fields) == MAX_FIELDS:
            source.fail(f"a message can have at most {MAX_FIELDS} fields; use arrays or nested messages")
        names.add(field.name)
        fields.append(field)
    return MessageSpec(package, name, tuple(fields), tuple(constants), text)


def _parse_field(line: SourceLine, package: str) -> Field:
    words = line.declaration.split()
    if len(words) != 2:
        line.fail(f"{quote(line.declaration.strip())} is not 'type name' or 'type NAME=value'")
    type_text, name = words
    found = _FIELD_TYPE.fullmatch(type_text)
    if found is None:
        line.fail(
            f"{quote(type_text)} is not a type such as uint8, float32[3], string[] or package/Name", type_text
        )
    if not _IDENTIFIER.fullmatch(name):
        line.fail(f"{quote(name)} is not a field name: a letter, then letters, digits and '_'", name)
    base, brackets, length_text = found.groups()
    if type_text == _HEADER:
        base = _HEADER_FULL_NAME
    elif "/" not in base and base not in PRIMITIVE_TYPES:
        base = f"{package}/{base}"
    if not length_text:
        return Field(FieldType(base, is_array=brackets is not None), name)
    length = int(length_text) if len(length_text) < 20 else MAX_ARRAY_LENGTH + 1
    if length > MAX_ARRAY_LENGTH:
        line.fail(f"{quote(type_text)}: an array can have at most {MAX_ARRAY_LENGTH} elements", type_text)
    return Field(FieldType(base, is_array=True, length=length, length_text=length_text), name)


def _parse_constant(line: SourceLine) -> Constant:
    left, _, right = line.text.partition("=")
    words = left.split()
    type_name = words[0] if words else ""
    if type_name.endswith("<"):
        line.fail(f"{quote(line.declaration.strip())} has a bound; only definitions of ROS 2 have bounds")
    if type_name not in CONSTANT_TYPES:
        line.fail(f"{quote(type_name)} cannot be the type of a constant", type_name)
    name = " ".join(words[1:])
    if not _CONSTANT_NAME.fullmatch(name):
        line.fail(
            f"{quote(name)} is not a constant's name: a letter, then letters, digits and '_'", words[-1]
        )
    if type_name == "string":
        # Everything after the first '=' belongs to the text: quotes, '#', more '='.
        text = right.strip()
        return Constant(type_name, name, text, text)
    text = " ".join(right.partition("#")[0].split())
    try:
        value = _constant_value(type_name, text)
    except ValueError as error:
        line.fail(f"{name}: {error}", text)
    return Constant(type_name, name, value, text)


def _constant_value(type_name: str, text: str) -> ConstantValue:
    if type_name in ("float32", "float64"):
        try:
            return float(text)
        except ValueError:
            raise ValueError(f"{quote(text)} is not a number") from None
    if type_name == "bool":
        return _bool_value(text)
    try:
        value = int(text)
    except ValueError:
        raise ValueError(f"{quote(text)} is not a decimal integer") from None
    low, high = INTEGER_RANGES[type_name]
    if not low <= value <= high:
        raise ValueError(f"{quote(text)} is outside {type_name} ({low} to {high})")
    return value


def _bool_value(text: str) -> bool:
    if text in _BOOLS:
        return _BOOLS[text]
    import ast

    try:
        if len(text) > _MAX_BOOL_CHARACTERS:
            raise ValueError(text)
        return bool(ast.literal_eval(text))
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        raise ValueError(f"{quote(text)} is not True, False, 1 or 0") from None
