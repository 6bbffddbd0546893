"""Generates the frame of a header: guard, includes, namespace, and protection from macros."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rostether.codegen.cpp_names import include_guard, namespace_name

_MESSAGE_HEADER = "ros/message.h"


def header(full_name: str, includes: Iterable[str], not_macros: Iterable[str], classes: Iterable[str]) -> str:
    """Return the text of the header of `package/Name`.

    `includes` are paths below the library's `src`. `not_macros` are names that the header uses even if a
    sketch or platform defines them as macros. `classes` are the lines of the namespace.
    """
    package = full_name.partition("/")[0]
    guard, namespace = include_guard(full_name), namespace_name(package)
    names = sorted(set(not_macros))
    lines = [
        f"// Generated from {full_name} by rostether; changes are lost when the library is generated again.",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        # In quotes, like the established libraries: scripts that move such a library rewrite these lines.
        f'#include "{_MESSAGE_HEADER}"',
        *(f'#include "{path}"' for path in sorted(set(includes))),
        "",
        *_push_macros(names),
        f"namespace {namespace} {{",
        "",
        *classes,
        "",
        f"}}  // namespace {namespace}",
        *_pop_macros(names),
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _push_macros(names: list[str]) -> Iterator[str]:
    for name in names:
        yield f'#pragma push_macro("{name}")'
        yield f"#undef {name}"
    if names:
        yield ""


def _pop_macros(names: list[str]) -> Iterator[str]:
    if names:
        yield ""
    for name in names:
        yield f'#pragma pop_macro("{name}")'
