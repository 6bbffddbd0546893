"""The frame of a header: guard, includes, namespace, and protection from macros."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rostether.codegen.cpp_names import include_guard, namespace_name

_MESSAGE_HEADER = "ros/message.h"


def header(full_name: str, includes: Iterable[str], sheltered: Iterable[str], classes: Iterable[str]) -> str:
    """Return the text of the header of `package/Name`.

    `includes` are paths below the library's `src`; `sheltered` the names that must not be replaced if they
    are macros where the header is included; `classes` the lines of its namespace.
    """
    package = full_name.partition("/")[0]
    guard, namespace = include_guard(full_name), namespace_name(package)
    names = sorted(set(sheltered))
    lines = [
        f"// Generated from {full_name} by rostether; changes are lost when the library is generated again.",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        # In quotes: scripts that move an established library below another folder rewrite these.
        f'#include "{_MESSAGE_HEADER}"',
        *(f'#include "{path}"' for path in sorted(set(includes))),
        "",
        *_set_aside(names),
        f"namespace {namespace} {{",
        "",
        *classes,
        "",
        f"}}  // namespace {namespace}",
        *_bring_back(names),
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _set_aside(names: list[str]) -> Iterator[str]:
    for name in names:
        yield f'#pragma push_macro("{name}")'
        yield f"#undef {name}"
    if names:
        yield ""


def _bring_back(names: list[str]) -> Iterator[str]:
    if names:
        yield ""
    for name in names:
        yield f'#pragma pop_macro("{name}")'
