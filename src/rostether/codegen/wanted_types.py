"""Chooses the messages and services of a library: all, those of packages, or those of a sketch."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable
from pathlib import Path

from msgspec import Struct, field

from rostether.codegen.sketch_includes import Include, unresolved_includes
from rostether.codegen.type_index import TypeIndex
from rostether.errors import DefinitionError, UnknownTypeError
from rostether.mechanisms.text import did_you_mean
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.unknown_type import explain_unknown

_TYPE_HEADER = re.compile(r"([A-Za-z][A-Za-z0-9_-]*)/([A-Za-z][A-Za-z0-9_]*)\.h")
# Packages of messages have these suffixes; other folders with headers do not.
_MESSAGE_PACKAGE = re.compile(r"\w+_(?:msgs|srvs|interfaces|messages)")


class WantedTypes(Struct):
    """Full names of the needed types, and one line for each include that fails or may fail."""

    names: set[str] = field(default_factory=set)
    missing: list[str] = field(default_factory=list)
    doubtful: list[str] = field(default_factory=list)


def all_types(index: TypeIndex) -> WantedTypes:
    """Return all known types."""
    return WantedTypes({*index.registry.messages(), *index.registry.services()})


def types_of_packages(index: TypeIndex, packages: Iterable[str]) -> WantedTypes:
    """Return the types of packages, or single types as `package/Name`, and the types of their fields.

    Raises UnknownTypeError for an unknown one.
    """
    wanted = WantedTypes()
    for each in packages:
        package, slash, short_name = each.partition("/")
        if slash:
            names = {each} if index.is_message(each) or index.is_service(each) else set()
            reason = explain_unknown(index.registry, Kind.MESSAGE, package, short_name)
        else:
            names = {*index.registry.messages(package), *index.registry.services(package)}
            meant = did_you_mean(package, index.registry.packages(), then=" Otherwise, ")
            reason = f"no package {package!r} is known; {meant}give its folder with --msg-path DIR"
        if not names:
            raise UnknownTypeError(reason)
        wanted.names |= names
    add_field_types(index, wanted)
    return wanted


def types_of_sketch(
    index: TypeIndex, sketch: Path | None, *, library_sources: Path, search: Iterable[Path] = ()
) -> WantedTypes:
    """Return the messages that a sketch and ros.h include, and the types of their fields.

    `search` are further folders of headers. Raises ConfigError if there is no such sketch.
    """
    wanted = WantedTypes()
    for include in unresolved_includes(
        sketch, library_sources=library_sources, start=["ros.h"], search=search
    ):
        match = _TYPE_HEADER.fullmatch(include.path)
        if match is None:
            continue
        name = f"{match[1]}/{match[2]}"
        if index.is_message(name) or index.is_service(name):
            wanted.names.add(name)
        else:
            _explain_include(index, include, match[1], match[2], wanted)
    add_field_types(index, wanted)
    return wanted


def add_field_types(index: TypeIndex, wanted: WantedTypes) -> None:
    """Add the types of the fields of all wanted messages."""
    for name in sorted(wanted.names):
        # A broken definition is reported when its header is written.
        with contextlib.suppress(DefinitionError):
            for spec in index.specs(name):
                parts = dependencies(spec, index.registry.message)
                wanted.names.update(index.header_of(part.full_name) for part in parts)


def _explain_include(
    index: TypeIndex, include: Include, package: str, short_name: str, wanted: WantedTypes
) -> None:
    reason = explain_unknown(index.registry, Kind.MESSAGE, package, short_name)
    if package in index.registry.packages() or _MESSAGE_PACKAGE.fullmatch(package):
        wanted.missing.append(f"{include.location}: {reason}")
    elif short_name[0].isupper() and package[0].islower():
        wanted.doubtful.append(f"{include.location}: if <{include.path}> is a message: {reason}")
