from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import ConfigError, LaunchError
from rostether.launch.files import BUILTIN_ROOT
from rostether.launch.scope import Scope
from rostether.launch.substitution import LaunchContext, substitute

SURROUNDINGS = LaunchContext(
    {"HOME": "/home/x", "TRICK": "$(find arm)/y"}, {"arm": Path("/ws/src/arm")}, frozenset({"xacro"})
)


def scope(**arguments: str) -> Scope:
    return Scope(file="/ws/src/arm/launch/a.launch", arguments=arguments)


@pytest.mark.parametrize(
    ("text", "result"),
    [
        ("plain", "plain"),
        ("$(arg x)/$(arg y)/$(arg x)", "1/two/1"),
        ("$(env HOME)", "/home/x"),
        ("$(optenv NOTHING)", ""),
        ("$(optenv NOTHING two words)", "two words"),
        ("$(optenv HOME other)", "/home/x"),
        ("$(dirname)/b", "/ws/src/arm/launch/b"),
        ("$(find arm)/urdf", "/ws/src/arm/urdf"),
        ("$(find arm)urdf", "/ws/src/arm/urdf"),
        ("-d $(find arm) -x", "-d /ws/src/arm -x"),
        ("$(find xacro)/xacro", f"{BUILTIN_ROOT}/xacro/xacro"),
        # A value may contain $(find), but no other substitution.
        ("$(env TRICK)", "/ws/src/arm/y"),
        ("$(arg z)", "$(arg x)"),
        ("$$(arg x)", "$1"),
        ("$(arg x", "$(arg x"),
        ("$(eval x + 1)", "2"),
        ("$(eval 'x')$(arg x)", None),
    ],
)
def test_text_with_substitutions(text: str, result: str | None) -> None:
    given = scope(x="1", y="two", z="$(arg x)")
    if result is None:
        with pytest.raises((LaunchError, ConfigError)):
            substitute(text, given, SURROUNDINGS)
    else:
        assert substitute(text, given, SURROUNDINGS) == result


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("$(arg x)" * 10, "v" * 1_000_000),
        # A value that contains its own substitution.
        ("$(arg x)" * 40, "$(arg x)$(arg x)"),
        ("$(arg x)" * 20_000, "v"),
    ],
)
def test_a_text_that_grows_beyond_the_limit_is_refused(text: str, value: str) -> None:
    with pytest.raises(LaunchError, match=r"longer than|more than"):
        substitute(text, scope(x=value), SURROUNDINGS)


def test_anonymous_name_is_the_same_in_a_scope_and_differs_elsewhere() -> None:
    here = scope()
    first = substitute("$(anon node)", here, SURROUNDINGS)
    assert first.startswith("node_")
    assert substitute("$(eval anon('node'))", here, SURROUNDINGS) == first
    assert substitute("$(anon node)", here.child(), SURROUNDINGS) == first
    assert substitute("$(anon node)", scope(), SURROUNDINGS) != first


def test_expression_that_is_only_a_part_is_refused_with_the_next_step() -> None:
    with pytest.raises(LaunchError, match="has to be the whole value"):
        substitute("a $(eval max(1, 2))", scope(), SURROUNDINGS)


@pytest.mark.parametrize(
    ("expression", "result"),
    [
        ("x * 2", "2"),
        ("arg('x') == 1 and not flag", "False"),
        ("len(word) + max(1, 2)", "5"),
        ("{'a': 1}['a']", "1"),
        ("(1, 'b')", "(1, 'b')"),
        ("[w for w in word if w != 'b']", "['a', 'c']"),
        ("radians(180) == pi", "True"),
        ("find('arm') + env('HOME')", "/ws/src/arm/home/x"),
        ("optenv('NOTHING', 'd')", "d"),
        ("float(x) / 2", "0.5"),
        ("None", "None"),
    ],
)
def test_expression(expression: str, result: str) -> None:
    given = scope(x="1", flag="true", word="abc")
    assert substitute(f"$(eval {expression})", given, SURROUNDINGS) == result


@pytest.mark.parametrize(
    "expression",
    [
        "open('/etc/passwd')",
        "().__class__",
        "x.real.imag",
        "(lambda: 1)()",
        "exec('1')",
        "getattr(x, 'real')",
        "1 / 0",
        "nobody",
        "env('NOTHING')",
        "find('nothing')",
    ],
)
def test_expression_that_is_refused(expression: str) -> None:
    with pytest.raises((LaunchError, ConfigError)) as caught:
        substitute(f"$(eval {expression})", scope(x="1"), SURROUNDINGS)
    assert "\n" not in str(caught.value)
