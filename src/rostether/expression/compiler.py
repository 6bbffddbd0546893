"""Expressions that users type: `m.range < 0.5 and m.header.frame_id == 'sonar'`, or `pi/2` in rad(pi/2).

The language is the part of Python that rostopic's users type. Our own evaluator accepts only a syntax tree of
allowed nodes, so a pasted line can use only the functions, modules and attributes below.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rostether.errors import ConfigError
from rostether.expression.budget import Budget
from rostether.rostime import Duration, Time

# Users type less. The limit also bounds the nesting of brackets and operators.
MAX_EXPRESSION_CHARS = 2000

Scope: TypeAlias = Mapping[str, Any]
Evaluate: TypeAlias = Callable[[Scope], Any]

FUNCTIONS: dict[str, Callable[..., Any]] = {
    function.__name__: function
    for function in (abs, all, any, bool, float, int, len, max, min, round, sorted, str, sum)
}
MATH = {name: getattr(math, name) for name in dir(math) if not name.startswith("_")}
_TIME_ATTRIBUTES: dict[str, Callable[[Any], Any]] = {
    "secs": lambda time: time.secs,
    "nsecs": lambda time: time.nsecs,
    "to_sec": lambda time: time.to_s,
    "to_nsec": lambda time: time.to_ns,
}
_STRING_METHODS = frozenset(
    (
        *("startswith", "endswith", "lower", "upper", "title", "capitalize", "strip", "lstrip", "rstrip"),
        *("find", "rfind", "count", "index", "isdigit", "isalpha", "isalnum", "split", "rsplit", "join"),
        *("replace", "zfill", "removeprefix", "removesuffix"),
    )
)


_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.RShift: operator.rshift,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda item, container: item in container,
    ast.NotIn: lambda item, container: item not in container,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}

# RecursionError: an expression of the maximum length can be nested deeper than the stack.
_FAILURES = (TypeError, ValueError, ArithmeticError, LookupError, AttributeError, RecursionError, MemoryError)

_SEQUENCES: dict[type[ast.expr], Callable[..., Any]] = {ast.List: list, ast.Tuple: tuple, ast.Set: set}


def compile_filter(expression: str) -> Callable[[object, str], bool]:
    """Return a test of a message `m` and its `topic`.

    Raises ConfigError for an expression that is not allowed. The test raises ConfigError if a message has no
    such field or the types do not fit.
    """
    evaluate = compile_expression(expression, frozenset(("m", "topic")), source="--filter")
    return lambda message, topic: bool(evaluate({"m": message, "topic": topic}))


def compile_expression(expression: str, names: frozenset[str], *, source: str) -> Evaluate:
    """Return a function that computes the expression from values for `names`; errors start with `source`.

    Raises ConfigError for an expression that is not allowed. The function raises ConfigError if the
    computation fails, needs too many steps, or creates a value that is too large.
    """
    if len(expression) > MAX_EXPRESSION_CHARS:
        raise ConfigError(f"{source}: longer than {MAX_EXPRESSION_CHARS} characters; use a script instead")
    budget = Budget()
    try:
        evaluate = _Compiler(names, budget).compile(ast.parse(expression.strip(), mode="eval").body)
    except ConfigError as error:
        raise ConfigError(f"{source}: {error}") from None
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        # A line number does not help in a text that is one line.
        problem = error.msg if isinstance(error, SyntaxError) else error
        if re.search(r"[^=!<>]=(?!=)", expression):
            problem = "write == to compare"
        raise ConfigError(f"{source}: {expression!r} is not an expression ({problem})") from None

    def compute(scope: Scope) -> Any:
        budget.restart()
        try:
            return evaluate(scope)
        except ConfigError as error:
            raise ConfigError(f"{source}: {error}") from None
        except _FAILURES as error:
            raise ConfigError(f"{source}: {expression!r} does not work: {error}") from None

    return compute


class _Compiler:
    """Compiles syntax trees to functions of a scope. Their operations share one budget."""

    def __init__(self, names: frozenset[str], budget: Budget) -> None:
        self._names = names
        self._budget = budget
        self._binary: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
            **_BINARY,
            ast.Mult: budget.multiply,
            ast.Mod: budget.modulo,
            ast.Pow: budget.power,
            ast.LShift: budget.shift_left,
        }

    def compile(self, node: ast.expr) -> Evaluate:  # noqa: C901, PLR0911, PLR0912 - one case for each kind of expression
        """Return a function that computes a node. Raises ConfigError if the node is not allowed."""
        compile_, budget = self.compile, self._budget
        match node:
            case ast.Constant(value=value):
                return lambda scope: value
            case ast.Name(id=name):
                return self._name(name)
            case ast.Attribute(value=inner, attr=attribute):
                owner = compile_(inner)
                return lambda scope: _attribute(owner(scope), attribute)
            case ast.Subscript(value=inner, slice=ast.Slice() as part):
                owner, cut = compile_(inner), compile_(part)
                return lambda scope: budget.result(owner(scope)[cut(scope)])
            case ast.Subscript(value=inner, slice=index):
                owner, position = compile_(inner), compile_(index)
                return lambda scope: owner(scope)[position(scope)]
            case ast.Slice(lower=lower, upper=upper, step=step):
                parts = [compile_(part) if part else lambda _: None for part in (lower, upper, step)]
                return lambda scope: slice(*(part(scope) for part in parts))
            case ast.UnaryOp(op=unary, operand=operand):
                value_of, apply_unary = compile_(operand), _UNARY[type(unary)]
                return lambda scope: apply_unary(value_of(scope))
            case ast.BinOp(left=left, op=binary, right=right) if type(binary) in self._binary:
                first, second, apply = compile_(left), compile_(right), self._binary[type(binary)]
                return lambda scope: budget.result(apply(first(scope), second(scope)))
            case ast.BoolOp(op=connective, values=values):
                return _connective(connective, [compile_(value) for value in values])
            case ast.Compare():
                return self._comparison(node)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                condition, yes, no = (compile_(part) for part in (test, body, orelse))
                return lambda scope: yes(scope) if condition(scope) else no(scope)
            case ast.List(elts=items) | ast.Tuple(elts=items) | ast.Set(elts=items):
                compiled, make = [compile_(item) for item in items], _SEQUENCES[type(node)]
                if all(isinstance(item, ast.Constant) for item in items):
                    constant = make(item({}) for item in compiled)
                    return lambda scope: constant
                return lambda scope: budget.result(make(item(scope) for item in compiled))
            case ast.Dict(keys=keys, values=values) if None not in keys:
                pairs = [
                    (compile_(key), compile_(value))
                    for key, value in zip(keys, values, strict=True)
                    if key is not None
                ]
                return lambda scope: budget.result({key(scope): value(scope) for key, value in pairs})
            case (
                ast.GeneratorExp(elt=element, generators=[loop])
                | ast.ListComp(elt=element, generators=[loop])
            ):
                return self._loop(element, loop)
            case ast.Call(func=function, args=arguments, keywords=[]):
                callee = compile_(function)
                values_of = [compile_(argument) for argument in arguments]
                return lambda scope: budget.call(callee(scope), [value(scope) for value in values_of])
        raise ConfigError(f"{ast.unparse(node)!r} is not allowed; use comparisons, arithmetic and m's fields")

    def _name(self, name: str) -> Evaluate:
        if name in self._names:
            return lambda scope: scope[name]
        if name in FUNCTIONS:
            function = FUNCTIONS[name]
            return lambda scope: function
        if name == "math":
            return lambda scope: math
        known = ", ".join(sorted(self._names | FUNCTIONS.keys() | {"math"}))
        raise ConfigError(f"there is no name {name!r}; use {known}")

    def _comparison(self, node: ast.Compare) -> Evaluate:
        first, read = self.compile(node.left), self._budget.read
        rest = [
            (_COMPARE[type(op)], self.compile(operand))
            for op, operand in zip(node.ops, node.comparators, strict=True)
        ]

        def evaluate(scope: Scope) -> bool:
            left = read(first(scope))
            for compare, operand in rest:
                right = read(operand(scope))
                if not compare(left, right):
                    return False
                left = right
            return True

        return evaluate

    def _loop(self, element: ast.expr, loop: ast.comprehension) -> Evaluate:
        if not isinstance(loop.target, ast.Name) or loop.is_async:
            raise ConfigError("a loop can have only one variable, for example any(r < 1 for r in m.ranges)")
        variable, budget = loop.target.id, self._budget
        body = _Compiler(self._names | {variable}, budget)
        items, value = self.compile(loop.iter), body.compile(element)
        conditions = [body.compile(condition) for condition in loop.ifs]
        nodes = (node for part in (element, *loop.ifs) for node in ast.walk(part))
        steps = sum(isinstance(node, ast.expr) for node in nodes)

        def evaluate(scope: Scope) -> list[Any]:
            inside = dict(scope)
            values: list[Any] = []
            for inside[variable] in items(scope):
                budget.spend(steps)
                if not conditions or all(condition(inside) for condition in conditions):
                    values.append(budget.read(value(inside)))
            return values

        return evaluate


def _connective(connective: ast.boolop, values: list[Evaluate]) -> Evaluate:
    stops_at = isinstance(connective, ast.Or)

    def evaluate(scope: Scope) -> Any:
        result: Any = None
        for value in values:
            result = value(scope)
            if bool(result) is stops_at:
                break
        return result

    return evaluate


def _attribute(owner: Any, name: str) -> Any:
    if isinstance(owner, Time | Duration):
        if name in _TIME_ATTRIBUTES:
            return _TIME_ATTRIBUTES[name](owner)
    elif owner is math:
        if name in MATH:
            return MATH[name]
    elif isinstance(owner, str):
        if name in _STRING_METHODS:
            return getattr(owner, name)
    elif name in getattr(type(owner), "__slots__", ()):
        return getattr(owner, name)
    fields = ", ".join(
        _TIME_ATTRIBUTES if isinstance(owner, Time | Duration) else getattr(type(owner), "__slots__", ())
    )
    known = f"the fields are {fields}" if fields else "this value has no fields"
    raise ConfigError(f"there is no .{name}; {known}")
