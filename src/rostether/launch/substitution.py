"""Substitutes `$(find pkg)`, `$(arg x)`, `$(env V)`, `$(optenv V words)`, `$(anon x)` and `$(dirname)`.

A text that is one `$(eval ...)` is evaluated. In other texts, `$(find ...)` is substituted last, so that the
values of the others may contain it. Substitutions cannot be nested.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from msgspec import Struct, field

from rostether.errors import LaunchError
from rostether.expression.compiler import FUNCTIONS, MATH, compile_expression
from rostether.launch.files import BUILTIN_ROOT
from rostether.launch.scope import Scope
from rostether.launch.values import convert
from rostether.mechanisms.anonymous import anonymous_name
from rostether.mechanisms.text import did_you_mean

_COMMANDS = ("find", "env", "optenv", "dirname", "anon", "arg")

# The limit of one text after substitution. A robot description, the longest in use, is about 100 KB.
_MAX_TEXT_CHARS = 4 << 20

# The limit of substitutions in one text: each of them copies the text.
_MAX_SUBSTITUTIONS = 10_000

_EVAL_PREFIX = "$(eval "

# The text after `$(`, and the character that ends it; none if the text ends first.
_SUBSTITUTION = re.compile(r"\$\(([^$()]*)([$()]?)")

_EXTRA: Mapping[str, Any] = {
    "list": list,
    "dict": dict,
    "tuple": tuple,
    "set": set,
    "map": map,
    "zip": zip,
    "range": range,
    "enumerate": enumerate,
    "reversed": reversed,
    "divmod": divmod,
    "chr": chr,
    "ord": ord,
    "hex": hex,
    "bin": bin,
    "oct": oct,
    "repr": repr,
}


class LaunchContext(Struct, frozen=True):
    """What launch files can read besides files: environment variables, packages and the output of commands.

    `packages` maps package names to folders. `programs` maps (package, program) to built-in command lines,
    for names such as `$(find xacro)/xacro` if the package is not installed. The packages of `programs` and
    the `builtin_packages` have no folders: their paths are below BUILTIN_ROOT, and no file exists there.
    Without `runs_commands`, a parameter with `command=` is an empty string.
    """

    environ: Mapping[str, str]
    packages: Mapping[str, Path]
    builtin_packages: Collection[str] = ()
    programs: Mapping[tuple[str, str], Sequence[str]] = field(default_factory=dict)
    runs_commands: bool = True


def substitute(text: str, scope: Scope, context: LaunchContext) -> str:
    """Return a text with all substitutions made. Raises LaunchError, ConfigError."""
    if "$" not in text:
        return text
    if text.startswith(_EVAL_PREFIX) and text.endswith(")"):
        return _evaluate(text[len(_EVAL_PREFIX) : -1], scope, context)
    for found in _substitutions(text):
        text = _replaced(text, found, scope, context)
    for found in _substitutions(text):
        if found.split()[0] == "find":
            text = _with_package_folder(text, found, context)
    return text


def _environment_variable(name: str, context: LaunchContext) -> str:
    """Return an environment variable's value. Raises LaunchError when it is not set."""
    if name not in context.environ:
        raise LaunchError(f"the environment variable {name} is not set; set it, or use $(optenv {name})")
    return context.environ[name]


def _argument_value(name: str, scope: Scope) -> str:
    """Return an argument's value. Raises LaunchError if it has none."""
    if name in scope.arguments:
        return scope.arguments[name]
    if name in scope.declared:
        raise LaunchError(f"argument {name!r} has no value; give {name}:=VALUE, or a default in its <arg>")
    raise LaunchError(f"argument {name!r} is not declared here; add <arg name={name!r} default=.../> above")


def _scoped_anonymous_name(base_name: str, scope: Scope) -> str:
    """Return the name for `$(anon base_name)`, which is the same each time in a scope."""
    if base_name not in scope.anonymous_names:
        scope.anonymous_names[base_name] = anonymous_name(base_name)
    return scope.anonymous_names[base_name]


def _folder_of(file: str) -> str:
    """Return the absolute path of a launch file's folder."""
    return str(Path(file).parent.absolute())


def _package_folder(name: str, context: LaunchContext) -> str:
    """Return the folder of a package. Raises LaunchError when there is none."""
    if name in context.packages:
        return str(context.packages[name])
    if name in context.builtin_packages or any(name == package for package, _ in context.programs):
        return f"{BUILTIN_ROOT}/{name}"
    hint = did_you_mean(name, context.packages) or "add the folder that contains it to ROS_PACKAGE_PATH"
    raise LaunchError(f"there is no package {name!r}; {hint}")


def _replaced(text: str, found: str, scope: Scope, context: LaunchContext) -> str:
    command, *words = found.split()
    value: str | None = None
    match command:
        case "env":
            value = _environment_variable(_only(found, words), context)
        case "optenv":
            if not words:
                raise LaunchError(f"$({found}) needs the name of an environment variable")
            value = context.environ.get(words[0], " ".join(words[1:]))
        case "dirname":
            value = _folder_of(scope.file)
        case "anon":
            value = _scoped_anonymous_name(_only(found, words), scope)
        case "arg":
            value = _argument_value(_only(found, words), scope)
    if value is None:
        return text
    # Ten arguments that each contain the previous one ten times would reach 10 GB.
    grown_by = text.count(f"$({found})") * (len(value) - len(f"$({found})"))
    if len(text) + grown_by > _MAX_TEXT_CHARS:
        raise LaunchError(
            f"with $({found}), a text is longer than {_MAX_TEXT_CHARS} characters; shorten its value"
        )
    return text.replace(f"$({found})", value)


def _with_package_folder(text: str, found: str, context: LaunchContext) -> str:
    folder = _package_folder(_only(found, found.split()[1:]), context)
    before, _, after = text.partition(f"$({found})")
    # The path may start without a slash: `$(find pkg)urdf/a.urdf` is also in the package.
    joint = "/" if after and not after.startswith(("/", " ", "$")) else ""
    return before + folder + joint + after


def _only(found: str, words: list[str]) -> str:
    if len(words) != 1:
        raise LaunchError(f"$({found}) needs one name, as in $({found.split()[0]} NAME)")
    return words[0]


def _substitutions(text: str) -> Iterator[str]:
    """Yield the texts between `$(` and `)`; other dollar signs and brackets are plain characters."""
    found: list[str] = []
    for inner, end in _SUBSTITUTION.findall(text):
        if end == "$":
            raise LaunchError(f"{text!r}: $(...) cannot be nested; use $(eval ...)")
        if end == "(" and inner.startswith(_EVAL_PREFIX[2:]):
            raise LaunchError(f"{text!r}: $(eval ...) has to be the whole value; move the rest into it")
        if end == "(":
            raise LaunchError(f"{text!r}: there is a second '(' inside $(...); remove it")
        if end and inner:
            found.append(inner)
    if len(found) > _MAX_SUBSTITUTIONS:
        raise LaunchError(f"a text has more than {_MAX_SUBSTITUTIONS} substitutions $(...); split it")
    for each in found:
        if each.split()[:1] and each.split()[0] in _COMMANDS:
            continue
        raise LaunchError(f"$({each}) is unknown; known: $({'), $('.join(_COMMANDS)}) and $(eval ...)")
    yield from found


def _evaluate(expression: str, scope: Scope, context: LaunchContext) -> str:
    """Return the text of an expression's value. Raises LaunchError, ConfigError."""
    if "__" in expression:
        raise LaunchError(f"$(eval {expression}) must not contain a double underscore; use other names")

    # Arguments override Python's functions; `math` overrides arguments: `e` and `pi` are always numbers.
    names: dict[str, Any] = {
        **FUNCTIONS,
        **_EXTRA,
        **{name: convert(value, "auto") for name, value in scope.arguments.items()},
        **MATH,
        "true": True,
        "false": False,
        "arg": lambda name: convert(_argument_value(name, scope), "auto"),
        "env": lambda name: _environment_variable(name, context),
        "optenv": lambda name, default="": context.environ.get(name, default),
        "find": lambda package: _package_folder(package, context),
        "anon": lambda base_name: _scoped_anonymous_name(base_name, scope),
        "dirname": lambda: _folder_of(scope.file),
    }
    _check_names(expression, names, scope)
    return str(compile_expression(expression, frozenset(names), source=f"$(eval {expression})")(names))


def _check_names(expression: str, names: Mapping[str, Any], scope: Scope) -> None:
    """Raise LaunchError for a name that is not known, or is an argument without a value."""
    try:
        tree = ast.parse(expression.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError):
        # compile_expression raises an error with the reason.
        return
    used = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    loop_variables = {node.id for node in used if isinstance(node.ctx, ast.Store)}
    for node in used:
        if node.id not in names and node.id not in loop_variables and node.id != math.__name__:
            _argument_value(node.id, scope)
