from __future__ import annotations

import math
from typing import Any

import pytest

from rostether.expression import python_expression
from rostether.expression.python_expression import PythonEvaluator

FUNCTIONS: dict[str, Any] = {
    each.__name__: each
    for each in (
        *(list, dict, map, len, str, float, int, bool, min, max, round, sorted, range, enumerate, filter),
        *(frozenset, isinstance, ord, repr, reversed, set, sum, tuple, type, zip, pow, abs, bytes, divmod),
    )
}


def names() -> dict[str, Any]:
    return {"math": math, "d": {"a": [1, 2], "b": {"c": "x"}}, "l": [3, 1, 2], **FUNCTIONS}


@pytest.fixture(autouse=True)
def few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rostether.expression.budget.MAX_STEPS", 100_000)


@pytest.mark.parametrize(
    "expression",
    [
        "10**10**9",
        "'x' * 10**9",
        "[0] * 10**9",
        "math.factorial(10**6)",
        "list(map(math.factorial, [10**6]))",
        "sorted([10**6], key=math.factorial)",
        "max([10**6], key=lambda x: math.factorial(x))",
        "math.lcm(*range(1, 50000))",
        "pow(10, 10**9)",
        "1 << 10**10",
        "'%999999999d' % 1",
        "f'{1:>999999999}'",
        "f'{1:{10**9}}'",
        "'{:>999999999}'.format(1)",
        "'{:{}}'.format(1, 10**9)",
        "'{x:>999999999}'.format_map({'x': 1})",
        "'x'.ljust(10**9)",
        "str.rjust('x', 10**9)",
        "'x'.center(10**9)",
        "('\\t' * 100).expandtabs(10**9)",
        "('\\t' * 100).expandtabs(tabsize=10**9)",
        "('x' * 9999).translate({120: 'y' * 9999})",
        "b'x'.replace(b'x', b'y' * 9999) * 9999",
        "(1).to_bytes(byteorder='big', length=10**9)",
        "bytes(10**9)",
        "list(range(10**10))",
        "[*range(10**10)]",
        "sum(x for x in map(lambda y: y, range(10**10)))",
        "[[0 for x in range(1000)] for y in range(1000)]",
        "{x * (2**61 - 1) for x in range(3000)}",
        "{x * (2**61 - 1): 0 for x in range(3000)}",
        "{*[x * (2**61 - 1) for x in range(3000)]}",
        "dict.fromkeys([x * (2**61 - 1) for x in range(3000)])",
        "[m.extend(m) for m in [[0]] for x in range(40)]",
        "(lambda f: f(f, 40))(lambda f, n: f(f, n - 1) + f(f, n - 1) if n else 0)",
    ],
)
def test_endless_computations_and_values_are_refused(expression: str) -> None:
    with pytest.raises(OverflowError, match=r"bits is too large|steps|at most 1000"):
        PythonEvaluator().evaluate(expression, names())


@pytest.mark.parametrize(
    "expression",
    [
        "2 * math.pi / 3 - 1 % 2",
        "d['a'][0] if 'a' in d and 'z' not in d else d.get('b')",
        "{**d, 'e': 1, **dict(f=2)}",
        "dict([('a', 1)], b=2)",
        "dict(zip('ab', [1, 2]))",
        "frozenset([1, 2]) | {3} | {x for x in l}",
        "{k: len(v) for k, v in d.items() if v}",
        "[(i, x) for i, (x, y) in enumerate(zip(l, l)) if x > 1]",
        "sorted(l, key=lambda x: -x, reverse=True)",
        "min(l, key=abs), max(1, 2, 3), round(2.345, ndigits=2), sum([[1]], start=[])",
        "list(filter(None, [0, 1])), list(reversed(l)), list(map(str, l))",
        "f'{math.pi:.3f} {d!r:>30} {1:{8}} {\"a\"!s}{{}}'",
        "'{} {1[0]} {x.imag!r:>{width}}'.format(1, l, x=2j, width=5) if False else '{0} {1[0]}'.format(1, l)",
        "'{a:05.1f}'.format_map({'a': 3.14159})",
        "'{0:>4} {0.imag} {x!r:<5}|'.format(2, x='y')",
        "str.join(', ', map(str, l)) + 'ab'.upper() + str.strip(' x ')",
        "'a,b;c'.split(',') + ['%s=%d' % ('n', 5)]",
        "(1 < 2 < 3) and not (1 == 2) or l is not None",
        "l[1:] + l[::-1] + [l[-1]]",
        "(lambda *a, **k: (a, k))(1, *l, x=2, **{'y': 3})",
        "isinstance(1, int) and isinstance('', (str, int)) and type(1) is int",
        "(y := 5) + y",
        "[*l, *(x for x in l)]",
        "-7 // 2, ~5, 5 & 3 | 4 ^ 1, 1 << 5, 2**-1, 256 >> 2, divmod(7, 2), pow(2, 3, 5)",
        "dict.fromkeys(['a', 'b'], 0), {}.get('x', 1), [1, 2].index(2), (3).to_bytes(2, 'big')",
        "'x'.ljust(3) + 'y'.center(5, '*') + 'z'.zfill(4) + '\\t'.expandtabs(2)",
        "''.join(c for c in 'abc' if c != 'b')",
    ],
)
def test_expressions_have_the_value_of_python(expression: str) -> None:
    expected = eval(expression, {"__builtins__": {}, **names()})
    assert PythonEvaluator().evaluate(f" {expression} ", names()) == expected


@pytest.mark.parametrize(
    ("expression", "error"),
    [
        ("1 +", SyntaxError),
        ("nothing", NameError),
        ("1 / 0", ZeroDivisionError),
        ("open('x')", NameError),
        ("().__class__", ValueError),
        ("[x.__class__ for x in l]", ValueError),
        ("(lambda f: f(f))(lambda f: f(f))", RecursionError),
    ],
)
def test_errors_are_those_of_python(expression: str, error: type[Exception]) -> None:
    with pytest.raises(error):
        PythonEvaluator().evaluate(expression, names())


def test_all_expressions_of_a_document_share_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(python_expression, "MAX_TOTAL_STEPS", 200_000)
    evaluator = PythonEvaluator()
    with pytest.raises(OverflowError, match="all expressions together need more than 200000 steps"):
        for _ in range(10):
            assert evaluator.evaluate("len([0 for x in range(20000)])", names()) == 20_000


def test_a_nested_expression_shares_the_steps() -> None:
    evaluator = PythonEvaluator()

    class Lazy(dict[str, Any]):
        def __missing__(self, key: str) -> Any:
            if key == "n":
                return evaluator.evaluate("len([0 for x in range(4000)])", names())
            raise KeyError(key)

    lazy = Lazy(names())
    assert evaluator.evaluate("n + n", {}, lazy) == 8_000
    with pytest.raises(OverflowError, match="steps"):
        evaluator.evaluate(" + ".join("n" * 10), {}, lazy)
