"""Finds the prototypes that an Arduino sketch omits: it may use functions before their definition.

The IDE puts all prototypes before the first function. Here each one comes as late as possible: before the
first statement that uses the function. Thus parameters may have types of the sketch, and a global object can
get a callback that is defined below it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from msgspec import Struct

from rostether.firmware.cpp_tokens import Token, code_tokens
from rostether.firmware.declarations import (
    Function,
    Statement,
    parameter_count,
    read_statements,
    split_at_commas,
)

# Arduino.h declares them.
_DECLARED = frozenset(("setup", "loop", "main", "serialEvent"))
_MEMBER_ACCESS = (".", "->", "::")


class Prototype(Struct, frozen=True):
    """A declaration to insert at an offset; `definition_offset` is the position of the function.

    `moved` are the spans of default arguments, which are allowed only in the declaration.
    """

    text: str
    offset: int
    definition_offset: int
    moved: tuple[tuple[int, int], ...] = ()


def find_prototypes(text: str) -> list[Prototype]:
    """Return the prototypes that a sketch's text needs, by offset; inactive code in it must be blank."""
    statements = read_statements(code_tokens(text))
    macros = _macros(statements)
    used = [_names_used(statement, macros) for statement in statements]
    found = []
    for index, statement in enumerate(statements):
        function = statement.function
        if function is None or not statement.is_definition or function.name in _DECLARED:
            continue
        first_use = next((i for i in range(index) if function.name in used[i]), None)
        if first_use is None or _is_declared(function, statements[: first_use + 1]):
            continue
        position = max(first_use, _after_its_types(function, statements[:index]))
        while position < index and statements[position].tokens[0].kind == "directive":
            position += 1
        if position < index and (prototype := _prototype(function, statements[position].start)) is not None:
            found.append(prototype)
    return sorted(found, key=lambda prototype: prototype.offset)


def _macros(statements: Iterable[Statement]) -> dict[str, set[str]]:
    """Return the names that each macro may expand to, directly or through other macros."""
    macros: dict[str, set[str]] = {}
    for statement in statements:
        directive = statement.tokens[0]
        if directive.kind == "directive" and statement.declared:
            words = {token.text for token in code_tokens(directive.text.lstrip("#")) if token.kind == "name"}
            macros.setdefault(next(iter(statement.declared)), set()).update(words)
    return macros


def _names_used(statement: Statement, macros: dict[str, set[str]]) -> set[str]:
    if statement.tokens[0].kind == "directive":
        # A macro is used where it is written, not where it is defined.
        return set()
    own = set() if statement.function is None else {id(_name_token(statement.function))}
    names = set()
    previous = ""
    for token in statement.tokens:
        if token.kind == "name" and previous not in _MEMBER_ACCESS and id(token) not in own:
            names.add(token.text)
        previous = token.text
    pending = [name for name in names if name in macros]
    while pending:
        new = macros[pending.pop()] - names
        names |= new
        pending += [name for name in new if name in macros]
    return names


def _name_token(function: Function) -> Token:
    return next(
        token
        for token, following in zip(function.head, function.head[1:], strict=False)
        if token.text == function.name and following.text == "("
    )


def _is_declared(function: Function, before: Sequence[Statement]) -> bool:
    """Return whether one of the statements before a function already declares it."""
    return any(
        each.function is not None
        and each.function.name == function.name
        and not each.is_definition
        and parameter_count(each.function) == parameter_count(function)
        for each in before
    )


def _after_its_types(function: Function, before: Sequence[Statement]) -> int:
    """Return the first statement after which all types of the sketch in a function head are declared."""
    names = {token.text for token in function.head if token.kind == "name"} - {function.name}
    positions = []
    for name in names:
        position = next((i + 1 for i, each in enumerate(before) if name in each.declared), None)
        if position is not None:
            positions.append(position)
    return max(positions, default=0)


def _prototype(function: Function, offset: int) -> Prototype | None:
    head = list(function.head)
    if head[0].text == "template" and any(
        token.text == "=" for token in head[: head.index(_name_token(function))]
    ):
        # Default arguments of a template would be repeated.
        return None
    head = _without_stray_macros(head)
    linkage = 'extern "C" ' if function.is_extern_c and head[0].text != "extern" else ""
    text = f"{linkage}{' '.join(token.text for token in head)};"
    return Prototype(text.replace("\n", " "), offset, head[0].offset, _default_arguments(function))


def _without_stray_macros(head: list[Token]) -> list[Token]:
    """Drop `MACRO(x)` before a function: it is a separate statement without a semicolon."""
    if len(head) > 1 and head[1].text == "(" and head[0].text.isupper():
        closing = next((i for i, token in enumerate(head) if token.text == ")"), None)
        if closing is not None and closing + 1 < len(head):
            return head[closing + 1 :]
    return head


def _default_arguments(function: Function) -> tuple[tuple[int, int], ...]:
    spans = []
    for parameter in split_at_commas(function.parameters):
        equals = next((token for token in parameter if token.text == "="), None)
        if equals is not None:
            spans.append((equals.offset, parameter[-1].end))
    return tuple(spans)
