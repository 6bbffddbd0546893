"""Finds the messages and services that a MicroPython program imports: `from std_msgs.msg import String`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from rostether.codegen.type_index import TypeIndex
from rostether.codegen.wanted_types import WantedTypes
from rostether.errors import ConfigError
from rostether.msgdef.definition_files import Kind
from rostether.msgdef.unknown_type import explain_unknown

# No board has room for a larger program.
MAX_PROGRAM_BYTES = 1 << 20


def types_of_program(index: TypeIndex, program: Path) -> WantedTypes:
    """Return the types that a .py file, or each in a folder, imports.

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
