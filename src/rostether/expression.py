"""Expressions that users type: `m.range < 0.5 and m.header.frame_id == 'sonar'`, or `pi/2` in rad(pi/2).

The Python that rostopic's users type, read by our own evaluator over a whitelisted syntax tree: a message
from a board or a pasted line can name no function, module or attribute beyond the ones below.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rostether.errors import ConfigError
from rostether.rostime import Duration, Time

MAX_EXPRESSION_CHARS = 2000
"""Nobody types more; deeper nesting than this allows would only exhaust the stack."""

MAX_INTEGER_BITS = 1024
"""What a double can hold; `9**9**9` would compute for days."""

MAX_TEXT_CHARS = 1 << 20
"""No text or list that an expression makes is longer; `'a' * 10**10` would take all memory."""

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


def _power(base: Any, exponent: Any) -> Any:
    if isinstance(base, int) and isinstance(exponent, int):
        # 1**n stays 1.
        _check_bits(max(abs(base) - 1, 0).bit_length() * exponent)
    return base**exponent


def _multiply(left: Any, right: Any) -> Any:
    for sequence, times in ((left, right), (right, left)):
        is_repeated = isinstance(sequence, str | bytes | list | tuple) and isinstance(times, int)
        if is_repeated and len(sequence) * times > MAX_TEXT_CHARS:
            raise OverflowError(f"{times} times that is longer than {MAX_TEXT_CHARS}")
    return left * right


def _shift_left(value: Any, bits: Any) -> Any:
    if isinstance(bits, int):
        _check_bits(bits)
    return value << bits


def _check_bits(bits: int) -> None:
    if bits > MAX_INTEGER_BITS:
        raise OverflowError(f"a whole number of {bits} bits is beyond all measure")


_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: _multiply,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: _power,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.LShift: _shift_left,
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

_SEQUENCES: dict[type[ast.expr], Callable[..., Any]] = {ast.List: list, ast.Tuple: tuple, ast.Set: set}


def compile_filter(expression: str) -> Callable[[object, str], bool]:
    """Return a test of a message `m` and its `topic`.

    Raises ConfigError, and so does the test when a message has no such field or the types do not fit.
    """
    evaluate = compile_expression(expression, frozenset(("m", "topic")), source="--filter")
    return lambda message, topic: bool(evaluate({"m": message, "topic": topic}))


def compile_expression(expression: str, names: frozenset[str], *, source: str) -> Evaluate:
    """Return what computes the expression from values for `names`; `source` is what errors begin with.

    Raises ConfigError for what is not whitelisted; so does the computation where it does not work.
    """
    if len(expression) > MAX_EXPRESSION_CHARS:
        raise ConfigError(f"{source}: longer than {MAX_EXPRESSION_CHARS} characters: use a script instead")
    try:
        evaluate = _compile(ast.parse(expression.strip(), mode="eval").body, names)
    except ConfigError as error:
        raise ConfigError(f"{source}: {error}") from None
    except (SyntaxError, ValueError, RecursionError) as error:
        # A line number says nothing of one line.
        told = error.msg if isinstance(error, SyntaxError) else error
        raise ConfigError(f"{source}: {expression!r} is no expression ({told})") from None

    def compute(scope: Scope) -> Any:
        try:
            return evaluate(scope)
        except ConfigError as error:
            raise ConfigError(f"{source}: {error}") from None
        except (TypeError, ValueError, ArithmeticError, LookupError, AttributeError) as error:
            raise ConfigError(f"{source}: {expression!r} does not work: {error}") from None

    return compute


def _compile(node: ast.expr, names: frozenset[str]) -> Evaluate:
    match node:
        case ast.Constant(value=value):
            return lambda scope: value
        case ast.Name(id=name):
            return _compile_name(name, names)
        case ast.Attribute(value=inner, attr=attribute):
            owner = _compile(inner, names)
            return lambda scope: _attribute(owner(scope), attribute)
        case ast.Subscript(value=inner, slice=index):
            owner, position = _compile(inner, names), _compile(index, names)
            return lambda scope: owner(scope)[position(scope)]
        case ast.Slice(lower=lower, upper=upper, step=step):
            parts = [_compile(part, names) if part else _none for part in (lower, upper, step)]
            return lambda scope: slice(*(part(scope) for part in parts))
        case ast.UnaryOp(op=unary, operand=operand):
            value_of, apply_unary = _compile(operand, names), _UNARY[type(unary)]
            return lambda scope: apply_unary(value_of(scope))
        case ast.BinOp(left=left, op=binary, right=right) if type(binary) in _BINARY:
            first, second, apply = _compile(left, names), _compile(right, names), _BINARY[type(binary)]
            return lambda scope: apply(first(scope), second(scope))
        case ast.BoolOp(op=connective, values=values):
            return _compile_connective(connective, [_compile(value, names) for value in values])
        case ast.Compare():
            return _compile_comparison(node, names)
        case ast.IfExp(test=test, body=body, orelse=orelse):
            condition, yes, no = (_compile(part, names) for part in (test, body, orelse))
            return lambda scope: yes(scope) if condition(scope) else no(scope)
        case ast.List(elts=items) | ast.Tuple(elts=items) | ast.Set(elts=items):
            compiled, make = [_compile(item, names) for item in items], _SEQUENCES[type(node)]
            return lambda scope: make(item(scope) for item in compiled)
        case ast.Dict(keys=keys, values=values) if None not in keys:
            pairs = [
                (_compile(key, names), _compile(value, names))
                for key, value in zip(keys, values, strict=True)
                if key is not None
            ]
            return lambda scope: {key(scope): value(scope) for key, value in pairs}
        case ast.GeneratorExp(elt=element, generators=[loop]) | ast.ListComp(elt=element, generators=[loop]):
            return _compile_loop(element, loop, names)
        case ast.Call(func=function, args=arguments, keywords=[]):
            callee = _compile(function, names)
            values_of = [_compile(argument, names) for argument in arguments]
            return lambda scope: callee(scope)(*(value(scope) for value in values_of))
    raise ConfigError(f"{ast.unparse(node)!r} is not allowed: use comparisons, arithmetic and m's fields")


def _compile_name(name: str, names: frozenset[str]) -> Evaluate:
    if name in names:
        return lambda scope: scope[name]
    if name in FUNCTIONS:
        function = FUNCTIONS[name]
        return lambda scope: function
    if name == "math":
        return lambda scope: math
    known = ", ".join(sorted(names | FUNCTIONS.keys() | {"math"}))
    raise ConfigError(f"nothing is called {name!r} here: use {known}")


def _compile_connective(connective: ast.boolop, values: list[Evaluate]) -> Evaluate:
    stops_at = isinstance(connective, ast.Or)

    def evaluate(scope: Scope) -> Any:
        result: Any = None
        for value in values:
            result = value(scope)
            if bool(result) is stops_at:
                break
        return result

    return evaluate


def _compile_comparison(node: ast.Compare, names: frozenset[str]) -> Evaluate:
    first = _compile(node.left, names)
    rest = [
        (_COMPARE[type(op)], _compile(operand, names))
        for op, operand in zip(node.ops, node.comparators, strict=True)
    ]

    def evaluate(scope: Scope) -> bool:
        left = first(scope)
        for compare, operand in rest:
            right = operand(scope)
            if not compare(left, right):
                return False
            left = right
        return True

    return evaluate


def _compile_loop(element: ast.expr, loop: ast.comprehension, names: frozenset[str]) -> Evaluate:
    if not isinstance(loop.target, ast.Name) or loop.is_async:
        raise ConfigError("a loop has one name, as in any(r < 1 for r in m.ranges)")
    variable = loop.target.id
    inner = names | {variable}
    items, value = _compile(loop.iter, names), _compile(element, inner)
    conditions = [_compile(condition, inner) for condition in loop.ifs]

    def evaluate(scope: Scope) -> list[Any]:
        scopes = ({**scope, variable: item} for item in items(scope))
        return [value(each) for each in scopes if all(condition(each) for condition in conditions)]

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
    fields = ", ".join(getattr(type(owner), "__slots__", ())) or "no fields"
    raise ConfigError(f"there is no .{name} here; there is {fields}")


def _none(scope: Scope) -> None:
    return None
