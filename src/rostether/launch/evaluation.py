"""`$(eval ...)`: Python expressions over arguments, read by our own evaluator over a whitelisted syntax tree.

The name of an argument, or `arg('x')`, is replaced by its value, a number or boolean if it looks like one.
Also available: `env()`, `optenv()`, `find()`, `anon()`, `dirname()`, the functions of `math`, and `true`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from typing import Any

from rostether.errors import LaunchError
from rostether.expression.compiler import FUNCTIONS, MATH, compile_expression
from rostether.launch.scope import Scope
from rostether.launch.substitution import (
    LaunchContext,
    argument_value,
    environment_variable,
    folder_of,
    package_folder,
    scoped_anonymous_name,
)
from rostether.launch.values import convert

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


def evaluate(expression: str, scope: Scope, context: LaunchContext) -> str:
    """Return the text of an expression's value. Raises LaunchError, ConfigError."""
    if "__" in expression:
        raise LaunchError(f"$(eval {expression}) must not contain a double underscore")

    def argument(name: str) -> Any:
        return convert(argument_value(name, scope), "auto")

    def optional_variable(name: str, default: str = "") -> str:
        return context.environ.get(name, default)

    # Arguments override Python's functions; `math` overrides arguments: `e` and `pi` are always numbers.
    names: dict[str, Any] = {
        **FUNCTIONS,
        **_EXTRA,
        **{name: convert(value, "auto") for name, value in scope.arguments.items()},
        **MATH,
        "true": True,
        "false": False,
        "arg": argument,
        "env": lambda name: environment_variable(name, context),
        "optenv": optional_variable,
        "find": lambda package: package_folder(package, context),
        "anon": lambda base_name: scoped_anonymous_name(base_name, scope),
        "dirname": lambda: folder_of(scope.file),
    }
    _check_names(expression, names, scope)
    return str(compile_expression(expression, frozenset(names), source=f"$(eval {expression})")(names))


def _check_names(expression: str, names: Mapping[str, Any], scope: Scope) -> None:
    try:
        tree = ast.parse(expression.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError):
        # The message of the compiler contains the reason.
        return
    used = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    loop_variables = {node.id for node in used if isinstance(node.ctx, ast.Store)}
    for node in used:
        if node.id not in names and node.id not in loop_variables and node.id != math.__name__:
            argument_value(node.id, scope)
