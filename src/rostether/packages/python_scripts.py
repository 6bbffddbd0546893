"""Examines the text of a Python file: whether it is a module, and whether it was written for Python 2."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import ast

# A longer script was generated; parsing it would delay its start.
_MAX_BYTES = 1 << 20

# The errors of Python 3 for statements and literals that only Python 2 has.
_PYTHON_2_ERRORS = re.compile(
    r"Missing parentheses in call to '(print|exec)'|multiple exception types must be parenthesized|"
    r"leading zeros in decimal integer literals|inconsistent use of tabs"
)
_PYTHON_2_SYNTAX = re.compile(
    r"^\s*(print\b(?!\s*[(=.,])|raise\s+[\w.]+\s*,|exec\s+[\"'\w]|except\s+[\w.]+\s*,\s*\w+\s*:)"
    r"|`\w+`|<>|\bur[\"']"
)

# `except TYPE, NAME:`, which Python 3.14 accepts as two exception types. A lower-case name is a variable.
_PYTHON_2_EXCEPT = re.compile(r"^\s*except\s+[\w.]+\s*,\s*[a-z_]\w*\s*:", re.MULTILINE)

# Modules that have another name in Python 3; 2to3 renames them.
_PYTHON_2_MODULES = re.compile(
    "BaseHTTPServer|ConfigParser|Queue|SimpleHTTPServer|SocketServer|StringIO|Tkinter|__builtin__|cPickle|"
    "cStringIO|httplib|tkMessageBox|urllib2|urlparse|xmlrpclib"
)

# The limit of modules that are examined, because the script starts only afterwards.
_MAX_FILES = 50


def explain_python2(script: Path) -> str:
    """Return what to do with a script that is or imports Python 2 code; empty for other scripts."""
    for file, line, _ in _examine_all(script):
        if line:
            return f"{file}:{line}: written for Python 2; convert it with `2to3 -w {file}`"
    return ""


def imported_modules(script: Path) -> set[str]:
    """Return the modules that a script and the modules next to it import."""
    return {name for _, _, imported in _examine_all(script) for name in imported}


def _examine_all(script: Path) -> Iterator[tuple[Path, int, list[str]]]:
    """Yield a script and the modules next to it that it imports, each with the result of `_examine`."""
    waiting, seen = [script], {script}
    while waiting:
        file = waiting.pop(0)
        line, imported = _examine(file)
        yield file, line, imported
        beside = {file.parent / f"{name}.py" for name in imported} - seen
        if len(seen) + len(beside) <= _MAX_FILES:
            waiting += sorted(each for each in beside if each.is_file())
            seen |= beside


def _examine(script: Path) -> tuple[int, list[str]]:
    """Return the line of the first Python 2 code, 0 if there is none, and the imported modules."""
    data = _read(script)
    text = data.decode(errors="replace")
    line = 0
    imported: dict[str, int] = {}
    try:
        imported = _imports(_parse(data))
    except SyntaxError as error:
        number = error.lineno or 1
        lines = text.splitlines()
        if _PYTHON_2_ERRORS.search(error.msg) or _PYTHON_2_SYNTAX.search("".join(lines[number - 1 : number])):
            line = number
    except ValueError:
        # The text contains a zero byte.
        pass
    else:
        if caught := _PYTHON_2_EXCEPT.search(text):
            line = text.count("\n", 0, caught.start()) + 1
        else:
            old = (name for name in imported if _PYTHON_2_MODULES.fullmatch(name))
            line = next((imported[name] for name in old if not _is_beside(script, name)), 0)
    return line, list(imported)


def _imports(module: ast.Module) -> dict[str, int]:
    """Return the modules imported at the top level, with their lines, except those in a `try`."""
    import ast

    found: dict[str, int] = {}
    for each in module.body:
        if isinstance(each, ast.Import):
            found.update({name.name.partition(".")[0]: each.lineno for name in each.names})
        elif isinstance(each, ast.ImportFrom) and each.module and not each.level:
            found[each.module.partition(".")[0]] = each.lineno
    return found


def _is_beside(script: Path, name: str) -> bool:
    return (script.parent / f"{name}.py").exists() or (script.parent / name).is_dir()


def is_module(file: Path) -> bool:
    """Return whether the top level of a file has only definitions, with at least one function or class."""
    import ast

    try:
        body = _parse(_read(file)).body
    except (SyntaxError, ValueError):
        return False
    definitions = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    quiet = (*definitions, ast.Import, ast.ImportFrom, ast.Assign, ast.AnnAssign)
    return any(isinstance(each, definitions) for each in body) and all(
        isinstance(each, quiet) or (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))
        for each in body
    )


def _read(file: Path) -> bytes:
    try:
        with file.open("rb") as stream:
            data = stream.read(_MAX_BYTES + 1)
    except OSError:
        return b""
    return data if len(data) <= _MAX_BYTES else b""


def _parse(data: bytes) -> ast.Module:
    import ast

    with warnings.catch_warnings():
        # An invalid escape sequence causes only a warning.
        warnings.simplefilter("ignore")
        return ast.parse(data)
