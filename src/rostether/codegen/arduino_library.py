"""Generates the C++ client library for an Arduino sketchbook, for PlatformIO, or for `-I ros_lib/src`.

DIR/ros_lib/
    library.properties library.json keywords.txt ...    hand-written, from the client library
    src/ros.h src/ros/... src/tf/...                    hand-written
    src/sensor_msgs/Range.h ...                         generated, one header for each message or service
    examples/...                                        hand-written; only in a library of all messages
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Concatenate, ParamSpec

from msgspec import Struct

from rostether.codegen.library_folder import check_parent, write_library_folder
from rostether.codegen.library_source import SOURCE_FOLDER, client_library, library_contents
from rostether.codegen.message_headers import generate_headers
from rostether.codegen.type_index import TypeIndex
from rostether.codegen.wanted_types import all_types, types_of_packages, types_of_sketch
from rostether.errors import CodegenError
from rostether.msgdef.registry import Registry

LIBRARY_NAME = "ros_lib"

_P = ParamSpec("_P")
_KEYWORDS_FILE = "keywords.txt"
# The examples use messages of many packages.
_ONLY_WITH_ALL_TYPES = ("examples/", "extras/")


class RenderedLibrary(Struct, frozen=True):
    """The files of a library by their paths with slashes, and reports about them.

    `types` are the full names that have a header. `skipped` has one line for each package or include that
    could not be generated, with the reason. `warnings` are problems on other boards or systems.
    """

    files: Mapping[str, bytes]
    types: tuple[str, ...]
    skipped: tuple[str, ...]
    warnings: tuple[str, ...]


class WrittenLibrary(Struct, frozen=True):
    """A library on disk, and whether it replaced an older one."""

    path: Path
    replaced: bool
    library: RenderedLibrary


def writer_of(render: Callable[_P, RenderedLibrary]) -> Callable[Concatenate[Path, _P], WrittenLibrary]:
    """Return a function that writes what `render` returns to DIR/ros_lib, replacing an older one as a whole.

    It takes DIR and the arguments of `render`. Raises CodegenError if the path is in use or cannot be
    written, and the errors of `render`.
    """

    def write(directory: Path, /, *arguments: _P.args, **options: _P.kwargs) -> WrittenLibrary:
        directory = directory.expanduser()
        check_parent(directory, LIBRARY_NAME)
        rendered = render(*arguments, **options)
        target = directory / LIBRARY_NAME
        if target.resolve() == client_library().resolve():
            raise CodegenError(f"{target} is the hand-written library itself; give another folder")
        return WrittenLibrary(target, write_library_folder(target, rendered.files), rendered)

    return write


def render_library(
    registry: Registry,
    *,
    for_sketch: Path | None = None,
    packages: Collection[str] | None = None,
    search: Iterable[Path] = (),
) -> RenderedLibrary:
    """Return the library with all types; or, if given, with those of a sketch and those of packages.

    `search` are more folders with headers of the sketch. The same definitions give the same bytes.
    Raises ConfigError if there is no such sketch, UnknownTypeError for an unknown package, CodegenError if
    the hand-written library is missing.
    """
    source = client_library()
    index = TypeIndex(registry)
    is_complete = for_sketch is None and packages is None
    files = library_contents(source, () if is_complete else _ONLY_WITH_ALL_TYPES)
    if is_complete:
        wanted = all_types(index)
    else:
        wanted = types_of_sketch(index, for_sketch, library_sources=source / SOURCE_FOLDER, search=search)
        wanted.names |= types_of_packages(index, packages or ()).names
    prefix = f"{SOURCE_FOLDER}/"
    own_paths = [path.removeprefix(prefix) for path in files if path.startswith(prefix)]
    headers = generate_headers(index, wanted.names, own_paths=own_paths)
    files.update({prefix + path: text.encode() for path, text in headers.texts.items()})
    keywords = files.get(_KEYWORDS_FILE, b"").decode()
    files[_KEYWORDS_FILE] = keywords_with_classes(keywords, headers.classes).encode()
    return RenderedLibrary(
        dict(sorted(files.items())),
        tuple(sorted(headers.types)),
        (*wanted.missing, *headers.skipped),
        (*wanted.doubtful, *headers.warnings),
    )


write_library = writer_of(render_library)


def keywords_with_classes(library_keywords: str, classes: Iterable[str]) -> str:
    """Return a keywords.txt, which the Arduino IDE uses to color words, with more classes."""
    lines = library_keywords.rstrip("\n").splitlines()
    known = {line.partition("\t")[0] for line in lines}
    lines.extend(f"{name}\tKEYWORD1" for name in sorted(set(classes) - known))
    return "\n".join(lines) + "\n"
