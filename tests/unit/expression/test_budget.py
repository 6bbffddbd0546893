from __future__ import annotations

import math
from typing import Any

import pytest

from rostether.errors import ConfigError
from rostether.expression.budget import MAX_STEPS
from rostether.expression.compiler import FUNCTIONS, MATH, compile_expression

NAMES: dict[str, Any] = {
    **FUNCTIONS,
    **MATH,
    **{
        each.__name__: each for each in (list, dict, tuple, set, map, zip, range, enumerate, reversed, divmod)
    },
}


def computed(expression: str) -> Any:
    return compile_expression(expression, frozenset(NAMES), source="test")(NAMES)


@pytest.mark.parametrize(
    "expression",
    [
        "factorial(10**6)",
        "comb(10**7, 5 * 10**6)",
        "perm(10**6)",
        "prod(range(1, 10**6))",
        "prod([2**1000] * 100000)",
        "9**9**9",
        "2**-10**10 * 2**10**10",
        "1 << 10**10",
        "round(5, -10**9)",
        "int('f' * 100000, 16)",
        "2**1000 * 2**1000",
        "'%999999999d' % 1",
        "'%.999999999f' % 1",
        "'%*d' % (999999999, 1)",
        "b'%999999999d' % 1",
        "('%s' * 600) % (('x' * 10**6,) * 600)",
        "'x'.zfill(10**10)",
        "('a' * 10**6).replace('a', 'b' * 10**6)",
        "('b' * 10**6).join(['a'] * 10**6)",
        "('b' * 10**6).join('a' * 10**6)",
        "('x' * 3000000).strip('a' * 3000000 + 'x')",
        "'a' * 10**10",
        "[0] * 10**10",
        "sum([[0] * 9999] * 9999, [])",
        "list(range(10**10))",
        "[[[z for z in range(1000)] for y in range(1000)] for x in range(1000)]",
        "['a' * 1000000 for x in range(100000)]",
        "str([[[['a'] * 1000] * 1000] * 1000])",
        "[" * 60 + "0" + "] * 9" * 60,
        "list(map(list, [range(10**6)] * 10**6))",
        "list(zip(" + ", ".join(["range(10**6)"] * 50) + "))",
        # All numbers have the same hash: each is compared with all previous ones.
        "set([k * (2**61 - 1) for k in range(100000)])",
        "dict([[k * (2**61 - 1), 0] for k in range(100000)])",
        "len([[a == b for a in [[[1] * 50] * 50] * 3000] for b in [[[1] * 51] * 50] * 3000])",
    ],
)
def test_endless_computations_and_values_are_refused_in_one_line(expression: str) -> None:
    with pytest.raises(ConfigError, match=r"bits is too large|steps|at most 1000") as caught:
        computed(expression)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "expression",
    [
        "factorial(170) // factorial(169)",
        "comb(1000, 500) % 10**9",
        "comb(100000, 99999)",
        "perm(10, 3)",
        "prod([1.5, 2, 4], )",
        "sum([0.5] * 1000)",
        "sum([[1], [2, 3]], [])",
        "2**1000",
        "10**300",
        "(-2)**-2",
        "1**10**10",
        "round(3.14159, 2)",
        "round(15, -1)",
        "round(2.5)",
        "'%05.2f %s %(x)s' % {'x': 1} if False else '%05.2f %s' % (3.14159, [1])",
        "'%d %%' % 5",
        "'7'.zfill(3)",
        "'-'.join(['a', 'b'])",
        "'-'.join('ab')",
        "'-'.join(reversed(['a', 'b']))",
        "'a-b'.replace('-', '__').strip('a_')",
        "list(map(abs, [-1, 2]))",
        "list(zip([1, 2], 'ab'))",
        "dict([['a', 1]])",
        "dict({'a': 1})",
        "set([1, 2, 1])",
        "set()",
        "any([x > 3 for x in range(100000)])",
        "[x for x in [1, 2, 3] if x > 1 if x < 3]",
        "[[x * y for x in range(3)] for y in range(3)]",
        "(1, 2) < (1, 3) and 2 in [1, 2]",
    ],
)
def test_valid_expressions_have_the_value_of_python(expression: str) -> None:
    assert computed(expression) == eval(expression, {"__builtins__": {}, **NAMES})


@pytest.mark.slow
def test_each_evaluation_starts_with_all_steps() -> None:
    evaluate = compile_expression("len([0 for x in y])", frozenset(("y",)), source="test")
    for _ in range(2):
        assert evaluate({"y": range(MAX_STEPS // 3)}) == MAX_STEPS // 3


def test_a_loop_variable_hides_no_name_outside() -> None:
    assert computed("[[e for e in range(2)], e]") == [[0, 1], math.e]
