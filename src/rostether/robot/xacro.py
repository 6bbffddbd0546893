"""Expands xacro files with the package xacro (extra `robot`), and finds packages for $(find).

xacro evaluates expressions with Python, so it is used only for files that the user names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from rostether.bounded_yaml import MAX_TEXT_CHARS, load, safe_loader
from rostether.errors import ConfigError, RobotModelError
from rostether.expression.python_expression import PythonEvaluator
from rostether.extras import install_command
from rostether.mechanisms.text import did_you_mean, fold_line, read_failure
from rostether.names.remap import ASSIGNMENT
from rostether.robot.urdf import MAX_XML_BYTES, parse_robot_xml

_XACRO = re.compile(rb"<xacro:|xmlns:xacro")

# A large robot has about 100,000 elements. Macros that call two others, 30 levels deep, create 10**9.
MAX_ELEMENTS: Final = 250_000

# The same as the limit of a URDF's bytes.
MAX_CHARACTERS: Final = 64 * 1024 * 1024

_MISSING: Final = object()

# Separators that stay one character class in brackets: an unescaped `]` after the first would close it.
_SEPARATORS: Final = re.compile(r"\^?\]?(?:[^\]\\]|\\.)*", re.DOTALL)


def is_xacro(data: bytes) -> bool:
    """Return whether a robot description contains xacro, so that it must be expanded."""
    return _XACRO.search(data) is not None


def parse_mappings(words: Iterable[str]) -> dict[str, str]:
    """Return the values of `name:=value` arguments. Raises ConfigError for other arguments."""
    mappings = {}
    for word in words:
        name, assignment, value = word.partition(ASSIGNMENT)
        if not assignment or not name:
            raise ConfigError(f"{word!r} is not an argument of the xacro file; write name:=value")
        mappings[name] = value
    return mappings


def expand_xacro(file: Path, mappings: Mapping[str, str], *, packages: Mapping[str, Path]) -> str:
    """Return the URDF that a xacro file expands to.

    `mappings` are the values of its arguments, `packages` the folders for $(find). Raises RobotModelError,
    for example if the package xacro is not installed.
    """
    xacro = _xacro(file)
    try:
        _check_file(file)
    except OSError as error:
        raise RobotModelError(read_failure(file, error)) from error
    with _bounded(xacro, file, _find_in(packages)):
        try:
            document = xacro.process_file(str(file), mappings=dict(mappings))
        except RobotModelError:
            raise
        except RecursionError as error:
            raise RobotModelError(
                f"{file}: its macros or files call each other endlessly; end the recursion with <xacro:if>"
            ) from error
        # Expressions in the file may raise any exception.
        except Exception as error:
            raise RobotModelError(_explain(file, xacro, error)) from error
    text: str = document.toprettyxml(indent="  ")
    return text


def xacro_dependencies(file: Path, mappings: Mapping[str, str], *, packages: Mapping[str, Path]) -> list[str]:
    """Return the files that a xacro file includes, sorted. Raises RobotModelError."""
    xacro = _xacro(file)
    xacro.all_includes.clear()
    expand_xacro(file, mappings, packages=packages)
    return sorted(set(xacro.all_includes))


def _xacro(file: Path) -> Any:
    try:
        import xacro
        import xacro.substitution_args
    except ImportError:
        raise RobotModelError(
            f"{file} is xacro, which needs the package xacro; run: {install_command('robot')}"
        ) from None
    return xacro


def _find_in(packages: Mapping[str, Path]) -> Callable[[str], str]:
    """Return the function for $(find): xacro's own needs the ament index of ROS 2, which is not installed."""

    def find(name: str) -> str:
        folder = packages.get(name)
        if folder is None:
            hint = did_you_mean(name, packages) or "`rostether pkg list` shows those found"
            raise RobotModelError(
                f"$(find {name}): no package {name} on ROS_PACKAGE_PATH, in the workspace around this folder "
                f"or below it; {hint}"
            )
        return str(folder)

    return find


def _explain(file: Path, xacro: Any, error: Exception) -> str:
    cause: BaseException = error
    while isinstance(inner := getattr(cause, "exc", None) or cause.__cause__, Exception):
        cause = inner
    file_name = next((str(each) for each in reversed(xacro.filestack or ()) if each), str(file))
    if isinstance(cause, OSError) and cause.filename is not None:
        return f"{file_name}: {read_failure(Path(cause.filename), cause)}"
    if isinstance(cause, UnicodeDecodeError):
        return f"{file_name}: not UTF-8 text at byte {cause.start}; save it as UTF-8"
    text = fold_line(str(error)) or type(cause).__name__
    return text if isinstance(cause, RobotModelError) else f"{file_name}: {text}"


@contextmanager
def _bounded(xacro: Any, file: Path, find: Callable[[str], str]) -> Iterator[None]:
    """In the block, make xacro use `find`, and raise RobotModelError or OverflowError beyond the limits."""
    counter, evaluate = _Counter(xacro, file), PythonEvaluator().evaluate
    symbols, arguments = xacro._global_symbols, xacro.substitution_args
    load_yaml = _load_yaml(xacro)
    # Nested quantifiers would take exponential time for an unclosed quote.
    macro_argument = re.compile(xacro.re_macro_arg.pattern.replace(r"""[^\s'\"]+)+""", r"""[^\s'\"])+"""))
    replacements: list[tuple[dict[str, Any], str, Any]] = [
        (vars(xacro), "parse", _parse(xacro.parse)),
        (vars(xacro), "eval_all", counter.eval_all),
        (vars(xacro), "eval_text", counter.eval_text),
        (vars(xacro), "re_macro_arg", macro_argument),
        (vars(xacro), "safe_eval", evaluate),
        (vars(arguments), "eval", evaluate),
        (vars(arguments), "_eval_find", find),
        (arguments._eval_dict, "find", find),
        (symbols, "load_yaml", load_yaml),
        (symbols["xacro"], "load_yaml", load_yaml),
        (symbols["xacro"], "tokenize", _tokenize(xacro.tokenize)),
    ]
    before = [(names, name, dict.get(names, name, _MISSING)) for names, name, _ in replacements]
    try:
        _assign(replacements)
        yield
    finally:
        _assign(before)


def _assign(values: list[tuple[dict[str, Any], str, Any]]) -> None:
    for names, name, value in values:
        # xacro's tables print a warning when a global name changes.
        if value is _MISSING:
            dict.pop(names, name, None)
        else:
            dict.__setitem__(names, name, value)


class _Counter:
    """Counts the elements that xacro creates, and the characters of their texts."""

    def __init__(self, xacro: Any, file: Path) -> None:
        self._eval_all, self._eval_text = xacro.eval_all, xacro.eval_text
        self._file = file
        self._elements = self._characters = 0

    def eval_all(self, node: Any, macros: Any, symbols: Any) -> Any:
        self._elements += 1
        if self._elements > MAX_ELEMENTS:
            raise RobotModelError(
                f"{self._file} expands to more than {MAX_ELEMENTS} elements; simplify its macros"
            )
        return self._eval_all(node, macros, symbols)

    def eval_text(self, text: Any, symbols: Any) -> Any:
        result = self._eval_text(text, symbols)
        if isinstance(result, str):
            self._characters += len(result)
        if self._characters > MAX_CHARACTERS:
            raise RobotModelError(
                f"{self._file} expands to more than {MAX_CHARACTERS} characters; shorten its properties"
            )
        return result


def _check_file(file: Path) -> None:
    """Raise RobotModelError if a file is too large, or has a DTD: xacro reads and expands without limits."""
    with file.open("rb") as stream:
        parse_robot_xml(stream.read(MAX_XML_BYTES + 1), file=str(file))


def _parse(parse: Callable[..., Any]) -> Callable[..., Any]:
    """Return xacro.parse() with a check of each included file before it."""

    def checked(inp: Any, filename: Any = None) -> Any:
        if inp is None:
            # xacro reports a file that cannot be read.
            with suppress(OSError):
                _check_file(Path(filename))
        return parse(inp, filename)

    return checked


def _load_yaml(xacro: Any) -> Callable[[str], Any]:
    """Return xacro.load_yaml(), with a loader that bounds aliases, merges and numbers."""

    def load_yaml(name: str) -> Any:
        loader: Any = type("Loader", (safe_loader(),), {})
        for unit in xacro.ConstructUnits:
            loader.add_constructor(unit.value.tag, unit.constructor)
        path = xacro.abs_filename_spec(name)
        with Path(path).open(encoding="utf-8") as stream:
            text = stream.read(MAX_TEXT_CHARS + 1)
        xacro.filestack.append(path)
        try:
            return xacro.YamlListWrapper.wrap(load(text, loader))
        finally:
            xacro.filestack.pop()
            xacro.all_includes.append(path)

    return load_yaml


def _tokenize(tokenize: Callable[..., Any]) -> Callable[..., Any]:
    """Return xacro.tokenize() with a check of the separators, which become a part of a regular expression."""

    def checked(text: Any, sep: str = ",; ", skip_empty: bool = True) -> Any:
        if not _SEPARATORS.fullmatch(sep):
            raise ValueError(
                f"the separators {sep!r} have a ] that is not their first character; put it first"
            )
        return tokenize(text, sep, skip_empty)

    return checked
