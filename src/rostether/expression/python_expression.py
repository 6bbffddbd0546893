"""Evaluates any Python expression within a budget, for formats that allow the whole language, such as xacro.

The syntax tree is rewritten so that each call, operator and loop spends from a budget; Python evaluates the
rest. This bounds time and memory. It does not stop hostile code: a file that may name any attribute can
reach the interpreter.
"""

from __future__ import annotations

import ast
import re
import string
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache, partial
from types import CodeType, MethodDescriptorType
from typing import Any, Final

from rostether.expression.budget import MAX_DIGITS, Budget

# The limit for all expressions of one evaluator together: twenty seconds of computing.
MAX_TOTAL_STEPS: Final = 100_000_000

# A large robot has fewer different expressions.
_CACHED_EXPRESSIONS: Final = 2048

# These functions need types and functions as they are: a guard around an argument would change their result.
_NEED_PLAIN_ARGUMENTS: Final = (isinstance, issubclass, type, repr, str, hash)

_GUARDED_OPERATORS: Final[Mapping[type[ast.operator], str]] = {
    ast.Mult: "<multiply>",
    ast.Mod: "<modulo>",
    ast.Pow: "<power>",
    ast.LShift: "<shift>",
}

_LOAD: Final = ast.Load()

# Expressions that create containers or texts, whose sizes count as steps.
_CREATED: Final = (ast.List, ast.Tuple, ast.Dict, ast.ListComp, ast.JoinedStr)


class PythonEvaluator:
    """Evaluates the expressions of one document; beyond the limits it raises OverflowError."""

    def __init__(self) -> None:
        self._budget = Budget()
        self._left = MAX_TOTAL_STEPS
        # The depth of nesting: a name's value may be another expression, which is evaluated when it is read.
        self._depth = 0
        budget = self._budget
        self._guards: dict[str, Callable[..., Any]] = {
            "<multiply>": budget.multiply,
            "<modulo>": budget.modulo,
            "<power>": budget.power,
            "<shift>": budget.shift_left,
            "<result>": budget.result,
            "<read>": budget.read,
            "<container>": self._container,
            "<call>": self._call,
            "<each>": self._each,
            "<format>": self._format,
            "<set>": lambda values: budget.call(set, [values]),
            "<dict>": lambda pairs: budget.call(dict, [pairs]),
        }

    def evaluate(self, expression: str, names: dict[str, Any], local_names: Any = None) -> Any:
        """Return the value of an expression, evaluated like `eval(expression, names, local_names)`.

        Only the built-in functions in `names` are available; the guards are added to it. Raises SyntaxError,
        ValueError for a name that begins with `__`, OverflowError beyond a limit, and the errors of the
        expression itself.
        """
        code = _compile(expression.strip())
        names.update(__builtins__=self._guards)
        if self._depth == 0:
            self._budget.restart()
            if self._left < 0:
                raise OverflowError(
                    f"all expressions together need more than {MAX_TOTAL_STEPS} steps; simplify them"
                )
        self._depth += 1
        try:
            return eval(code, names, local_names)  # noqa: S307 - the guarded code
        finally:
            self._depth -= 1
            if self._depth == 0:
                self._left -= self._budget.spent

    def _call(self, function: Any, /, *arguments: Any, **named: Any) -> Any:
        if type(function) is partial:
            function = function.args[0]
        if isinstance(function, MethodDescriptorType) and arguments:
            # `str.join(',', items)` is `','.join(items)`.
            function, arguments = function.__get__(arguments[0]), arguments[1:]
        owner, name = getattr(function, "__self__", None), getattr(function, "__name__", "")
        if isinstance(owner, str) and name in ("format", "format_map"):
            values = arguments if name == "format" else ()
            return self._budget.call(
                lambda *_, **__: _Formatter(self._format).vformat(
                    owner, values, named if name == "format" else arguments[0]
                ),
                arguments,
                named,
            )
        if name == "fromkeys" and arguments:
            keys = list(arguments[0])
            # Raises OverflowError if there are too many keys that could share a hash.
            self._budget.call(set, [keys])
            arguments = (keys, *arguments[1:])
        if not any(function is each for each in _NEED_PLAIN_ARGUMENTS):
            arguments = tuple(map(self._guarded, arguments))
            named = {key: self._guarded(value) for key, value in named.items()}
        return self._budget.call(function, arguments, named)

    def _guarded(self, argument: Any) -> Any:
        if callable(argument) and type(argument) is not partial:
            return partial(self._call, argument)
        return argument

    def _each(self, items: Iterable[Any]) -> Iterator[Any]:
        for item in items:
            self._budget.spend(1)
            yield item

    def _container(self, value: Any) -> Any:
        # A search in a dict or set compares the keys that share one hash: at most all of them.
        if isinstance(value, dict | set | frozenset):
            self._budget.spend(len(value))
            return value
        return self._budget.read(value)

    def _format(self, value: Any, conversion: int, spec: str) -> str:
        if any(len(digits) > 4 or int(digits) > MAX_DIGITS for digits in re.findall(r"\d+", spec)):
            raise OverflowError(f"a width in a format must be at most {MAX_DIGITS}; use a smaller one")
        self._budget.read(value)
        conversions: dict[int, Callable[[Any], str]] = {ord("s"): str, ord("r"): repr, ord("a"): ascii}
        return format(conversions[conversion](value) if conversion in conversions else value, spec)


class _Formatter(string.Formatter):
    """str.format() that formats each field with the function `formatted`."""

    def __init__(self, formatted: Callable[[Any, int, str], str]) -> None:
        self._formatted = formatted

    def format_field(self, value: Any, format_spec: str) -> str:
        return self._formatted(value, -1, format_spec)


@lru_cache(maxsize=_CACHED_EXPRESSIONS)
def _compile(expression: str) -> CodeType:
    tree = ast.parse(expression, "<expression>", mode="eval")
    names = (getattr(node, "id", getattr(node, "attr", "")) for node in ast.walk(tree))
    if hidden := sorted({name for name in names if name.startswith("__")}):
        raise ValueError(f"names that begin with __ are not allowed: {', '.join(hidden)}")
    return compile(ast.fix_missing_locations(_Guard().visit(tree)), "<expression>", "eval")


class _Guard(ast.NodeTransformer):
    """Replaces expensive operations with calls to guards, whose names no expression can contain."""

    def visit(self, node: ast.AST) -> Any:
        node = super().visit(node)
        if isinstance(node, _CREATED) and isinstance(getattr(node, "ctx", _LOAD), ast.Load):
            return _guard("<result>", node)
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        guard = _GUARDED_OPERATORS.get(type(node.op))
        return _guard("<result>", _guard(guard, node.left, node.right) if guard else node)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        return ast.Call(ast.Name("<call>", _LOAD), [node.func, *node.args], node.keywords)

    def visit_comprehension(self, node: ast.comprehension) -> ast.comprehension:
        self.generic_visit(node)
        node.iter = _guard("<each>", node.iter)
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.Compare:
        self.generic_visit(node)
        node.left = _guard("<read>", node.left)
        node.comparators = [
            _guard("<container>" if isinstance(operator, ast.In | ast.NotIn) else "<read>", operand)
            for operator, operand in zip(node.ops, node.comparators, strict=True)
        ]
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        self.generic_visit(node)
        return _guard("<result>", node) if isinstance(node.slice, ast.Slice) else node

    def visit_FormattedValue(self, node: ast.FormattedValue) -> ast.FormattedValue:
        self.generic_visit(node)
        spec = node.format_spec or ast.Constant("")
        value = _guard("<format>", node.value, ast.Constant(node.conversion), spec)
        return ast.FormattedValue(value, -1, None)

    def visit_Set(self, node: ast.Set) -> ast.expr:
        self.generic_visit(node)
        return _guard("<set>", ast.List(node.elts, _LOAD))

    def visit_SetComp(self, node: ast.SetComp) -> ast.expr:
        self.generic_visit(node)
        return _guard("<set>", ast.ListComp(node.elt, node.generators))

    def visit_DictComp(self, node: ast.DictComp) -> ast.expr:
        self.generic_visit(node)
        pair = ast.Tuple([node.key, node.value], _LOAD)
        return _guard("<dict>", ast.ListComp(pair, node.generators))


def _guard(name: str, *arguments: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(name, _LOAD), list(arguments), [])
