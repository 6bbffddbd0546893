"""Generates the headers of messages and services, and reports the types that have no header."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from msgspec import Struct, field

from rostether.codegen.cpp_message import included_messages, message_class, possible_macros
from rostether.codegen.cpp_names import class_name, include_guard, include_path, name_members, namespace_name
from rostether.codegen.reserved_words import LIBRARY_NAMESPACE
from rostether.codegen.type_index import TypeIndex
from rostether.errors import CodegenError, RostetherError
from rostether.msgdef.md5sum import message_md5sum
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.spec import MessageSpec, ServiceSpec

# If a package needs another one that is missing, each of its types may fail; the first few show the reason.
MAX_FAILURES_SHOWN = 5

_MESSAGE_HEADER = "ros/message.h"

# Maps the full name of a message to the type whose header contains it: the message itself, or its service.
HeaderOf = Callable[[str], str]


class MessageHeaders(Struct):
    """The headers by path below the library's `src`, their types and classes, and lines for the user."""

    texts: dict[str, str] = field(default_factory=dict)
    types: list[str] = field(default_factory=list)
    classes: set[str] = field(default_factory=set)
    skipped: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def generate_headers(index: TypeIndex, names: Iterable[str], *, own_paths: Iterable[str]) -> MessageHeaders:
    """Generate the headers of types by their full names.

    `own_paths` are the hand-written headers, by path below the library's `src`.
    """
    result = MessageHeaders()
    failures: dict[str, list[str]] = {}
    own = set(own_paths)
    for name in sorted(names):
        failed = failures.setdefault(name.partition("/")[0], [])
        if index.is_message(name) and index.is_service(name):
            failed.append(f"the service {name}: a message has the same name; rename one")
        try:
            _check_place(index, name, own)
            text = _text(index, name, own)
        except RostetherError as error:
            failed.append(f"{name}: {error}")
            continue
        result.texts[include_path(name)] = text
        result.types.append(name)
        result.classes.add(class_name(name.partition("/")[2]))
    for failed in failures.values():
        result.skipped.extend(f"skipped {each}" for each in _first(failed))
    result.warnings.extend(_differing_only_in_case([*own, *result.texts]))
    return result


def _text(index: TypeIndex, name: str, own: set[str]) -> str:
    lookup = index.registry.message
    specs = index.specs(name)
    sums = [message_md5sum(spec, lookup) for spec in specs]
    for spec in specs:
        for part in dependencies(spec, lookup):
            _check_place(index, index.header_of(part.full_name), own)
    if index.is_message(name):
        return message_header(specs[0], sums[0], index.header_of)
    return service_header(index.registry.service(name), sums[0], sums[1], index.header_of)


def _check_place(index: TypeIndex, name: str, own: set[str]) -> None:
    package = name.partition("/")[0]
    if package == LIBRARY_NAMESPACE:
        raise CodegenError(f"the package {package!r} has the name of a folder in the library; rename it")
    if include_path(name) in own:
        raise CodegenError(f"the library already has a header {include_path(name)}; rename the type")
    if index.is_message(name):
        return
    for part in (f"{name}Request", f"{name}Response"):
        if index.is_message(part):
            raise CodegenError(f"there is also a message {part}; rename one, because C++ cannot have both")


def _first(failures: list[str]) -> list[str]:
    shown = failures[:MAX_FAILURES_SHOWN]
    if hidden := len(failures) - len(shown):
        shown[-1] += f" (and {hidden} more of this package)"
    return shown


def _differing_only_in_case(paths: Iterable[str]) -> Iterator[str]:
    by_folded: dict[str, list[str]] = {}
    for path in sorted(paths):
        by_folded.setdefault(path.casefold(), []).append(path)
    for same in by_folded.values():
        if len(same) > 1:
            yield (
                f"{' and '.join(same)} differ only in case; on Windows and macOS only one of them can exist;"
                " rename one"
            )


def message_header(spec: MessageSpec, md5sum: str, header_of: HeaderOf = str) -> str:
    """Return the text of a message's header."""
    return _header(spec.full_name, [spec], header_of, _class(spec, spec.full_name, md5sum))


def service_header(
    spec: ServiceSpec, request_md5sum: str, response_md5sum: str, header_of: HeaderOf = str
) -> str:
    """Return the text of a service's header.

    Request and response both announce the service's name, each with its own md5sum.
    """
    classes = (
        *_class(spec.request, spec.full_name, request_md5sum),
        "",
        *_class(spec.response, spec.full_name, response_md5sum),
        "",
        f"class {class_name(spec.name)} {{",
        " public:",
        f"  typedef {class_name(spec.request.name)} Request;",
        f"  typedef {class_name(spec.response.name)} Response;",
        "};",
    )
    return _header(spec.full_name, [spec.request, spec.response], header_of, classes)


def _class(spec: MessageSpec, type_name: str, md5sum: str) -> Iterator[str]:
    return message_class(spec, name_members(spec), type_name=type_name, md5sum=md5sum)


def _header(full_name: str, messages: list[MessageSpec], header_of: HeaderOf, classes: Iterable[str]) -> str:
    """Return the text of the header of `package/Name`; `classes` are the lines of its namespace."""
    guard, namespace = include_guard(full_name), namespace_name(full_name.partition("/")[0])
    includes = {include_path(header_of(name)) for each in messages for name in included_messages(each)}
    # The header uses these names even if a sketch or platform defines them as macros.
    macros = sorted({name for each in messages for name in possible_macros(name_members(each))})
    pushed = [line for name in macros for line in (f'#pragma push_macro("{name}")', f"#undef {name}")]
    popped = [f'#pragma pop_macro("{name}")' for name in macros]
    lines = [
        f"// Generated from {full_name} by rostether; changes are lost when the library is generated again.",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        # In quotes, like the established libraries: scripts that move such a library rewrite these lines.
        f'#include "{_MESSAGE_HEADER}"',
        *(f'#include "{path}"' for path in sorted(includes)),
        "",
        *([*pushed, ""] if pushed else []),
        f"namespace {namespace} {{",
        "",
        *classes,
        "",
        f"}}  // namespace {namespace}",
        *(["", *popped] if popped else []),
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)
