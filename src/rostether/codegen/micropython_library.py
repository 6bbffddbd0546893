"""Generates the MicroPython client library with messages, to be copied to a board's /lib.

DIR/ros_lib/
    ros/...                                    hand-written, from the client library
    std_msgs/msg/__init__.py _String.py ...    generated, one module per message, loaded when it is imported
    std_srvs/srv/__init__.py _SetBool.py ...   generated, one module per service
    examples/...                               hand-written; only in a library of all messages
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from pathlib import Path

from rostether.codegen.arduino_library import RenderedLibrary, writer_of
from rostether.codegen.library_source import MICROPYTHON_FOLDER, client_library, library_contents
from rostether.codegen.python_message import message_module, service_module
from rostether.codegen.python_names import MODULES, class_name, package_name
from rostether.codegen.reserved_words import LIBRARY_NAMESPACE
from rostether.codegen.type_index import TypeIndex
from rostether.codegen.wanted_types import WantedTypes, add_field_types, all_types, types_of_packages
from rostether.errors import CodegenError, ConfigError, RostetherError
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.registry import Registry
from rostether.msgdef.resolve_types import dependencies
from rostether.msgdef.unknown_type import explain_unknown

# No board has room for a larger program.
MAX_PROGRAM_BYTES = 1 << 20

_PACKAGE = '''"""Loads a message or service when it is imported."""


def __getattr__(name):
    if name.startswith("_"):
        raise AttributeError(name)
    return getattr(__import__(__name__ + "._" + name, None, None, (name,)), name)
'''


def render_micropython_library(
    registry: Registry, *, for_program: Path | None = None, packages: Collection[str] | None = None
) -> RenderedLibrary:
    """Return the library with all types; or, if given, with those of a program and those of packages.

    Raises ConfigError if the program cannot be read, UnknownTypeError for an unknown package, CodegenError if
    the hand-written library is missing.
    """
    index = TypeIndex(registry)
    source = client_library() / MICROPYTHON_FOLDER
    is_complete = for_program is None and packages is None
    if is_complete:
        wanted = all_types(index)
    else:
        wanted = WantedTypes() if for_program is None else _types_of_program(index, for_program)
        wanted.names |= types_of_packages(index, packages or ()).names
    # Examples use messages of many packages.
    files = library_contents(source, () if is_complete else ("examples/",))
    types: list[str] = []
    skipped: list[str] = list(wanted.missing)
    for name in sorted(wanted.names):
        try:
            texts = dict(_modules(index, name))
        except RostetherError as error:
            skipped.append(f"skipped {name}: {error}")
            continue
        if texts.keys() & files.keys():
            skipped.append(f"skipped {name}: another type has its name in Python; rename one")
            continue
        types.append(name)
        for path, text in texts.items():
            files[path] = text.encode()
            package = path.rpartition("/")[0]
            files[f"{package}/__init__.py"] = _PACKAGE.encode()
            files[f"{package.partition('/')[0]}/__init__.py"] = b""
    return RenderedLibrary(dict(sorted(files.items())), tuple(types), tuple(skipped), ())


write_micropython_library = writer_of(render_micropython_library)


def _modules(index: TypeIndex, name: str) -> Iterator[tuple[str, str]]:
    """Yield paths and texts of the modules for a name, which may belong to a message and to a service."""
    registry = index.registry

    def path_of(message: str) -> str:
        return _path(index, index.header_of(message))

    for spec in index.specs(name):
        for part in (spec, *dependencies(spec, registry.message)):
            if part.package == LIBRARY_NAMESPACE or part.package in MODULES:
                raise CodegenError(
                    f"the package {part.package!r} has the name of a module on the board; rename it"
                )
    if index.is_message(name):
        yield (f"{_path(index, name)}.py", message_module(registry.message(name), registry, path_of))
    if index.is_service(name):
        yield f"{_path(index, name, 'srv')}.py", service_module(registry.service(name), registry, path_of)


def _path(index: TypeIndex, name: str, kind: str = "") -> str:
    package, _, short_name = name.partition("/")
    kind = kind or ("msg" if index.is_message(name) else "srv")
    return f"{package_name(package)}/{kind}/_{class_name(short_name)}"


def _types_of_program(index: TypeIndex, program: Path) -> WantedTypes:
    """Return the types that a .py file or the .py files in a folder import, and the types of their fields.

    Raises ConfigError if a file cannot be read.
    """
    wanted = WantedTypes()
    files = sorted(program.glob("*.py")) if program.is_dir() else [program]
    if not files:
        raise ConfigError(f"no Python files in {program}; name the program of the board")
    for file in files:
        for line, package, kind, name in _imports(file):
            full_name = f"{package}/{name}"
            if index.is_message(full_name) if kind is Kind.MESSAGE else index.is_service(full_name):
                wanted.names.add(full_name)
            else:
                reason = explain_unknown(index.registry, kind, package, name)
                wanted.missing.append(f"{file}:{line}: {reason}")
    add_field_types(index, wanted)
    return wanted


def _imports(file: Path) -> Iterator[tuple[int, str, Kind, str]]:
    for node in ast.walk(_parse(file)):
        if not isinstance(node, ast.ImportFrom) or node.module is None or node.level:
            continue
        package, dot, kind = node.module.rpartition(".")
        if not dot or "." in package or kind not in ("msg", "srv"):
            continue
        for each in node.names:
            yield node.lineno, package, Kind.MESSAGE if kind == "msg" else Kind.SERVICE, each.name


def _parse(file: Path) -> ast.Module:
    try:
        if file.stat().st_size > MAX_PROGRAM_BYTES:
            raise ConfigError(f"{file} is larger than 1 MiB; name the program of the board")
        return ast.parse(file.read_bytes())
    except OSError as error:
        raise ConfigError(f"cannot read {file}: {error.strerror}; name the program of the board") from error
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ConfigError(f"{file} is not a Python program: {error}") from error
