from __future__ import annotations

import ast
import math
from pathlib import Path

import pytest

import rostether
from rostether.bounded_yaml import (
    MAX_ALIASED_VALUES,
    MAX_MERGES,
    MAX_NESTING,
    MAX_NUMBER_CHARS,
    MAX_VALUES,
    YamlError,
    has_alias,
    load,
    load_all,
)

pytestmark = pytest.mark.slow

PADDING = "# " + "x" * 10_000 + "\n"


def chain(first: str, link: str, length: int) -> str:
    """Return `length` lines, each an anchor whose value refers to the one above."""
    lines = [f"a0: &a0 {first}"]
    lines += [f"a{index}: &a{index} " + link.format(f"*a{index - 1}", index) for index in range(1, length)]
    return "\n".join(lines)


HOSTILE = {
    "aliases that multiply": (chain("[x, x]", "[{0}, {0}, {0}, {0}, {0}]", 30), "aliases"),
    "merges that multiply": (chain("{k: v}", "{{<<: [{0}, {0}]}}", 60), "aliases"),
    "a long chain of merges": (chain("{k: v}", "{{<<: {0}, k{1}: v}}", 5000), "aliases"),
    "a long chain of lists": (chain("[1]", "[{0}]", 1500), "aliases"),
    "many merges in one mapping": (f"a: &a {{}}\nb: {{{'<<: *a, ' * 300_000}}}", "merges"),
    "a long text repeated": (f"a: &a {'x' * 1_000_000}\nb: [{'*a, ' * 1_000}]", "aliases"),
    "an alias inside of itself": ("&a [*a]", "endless"),
    "a number to the base 60": (f"a: 1{':1' * 1_000_000}", "characters"),
    "a fraction to the base 60": (f"a: 1{':1' * 1_000_000}.5", "characters"),
    "decimal digits": ("9" * 1_000_000, "characters"),
    "hexadecimal digits": ("0x" + "9" * 1_000_000, "characters"),
    "lists in lists": ("[" * 100_000, "levels"),
    "mappings in mappings": ("{a: " * 100_000, "levels"),
    "indented lists": ("- " * 100_000, "levels"),
    "complex keys": ("? " * 100_000, "levels"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_would_grow_without_end_is_refused_in_one_line(name: str) -> None:
    text, reason = HOSTILE[name]
    with pytest.raises(YamlError, match=reason) as caught:
        load(text)
    assert len(str(caught.value)) < 200
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["2001-99-99", "!!bool x", "!!timestamp x", "!!int ''", "!!float ''", "!!int x"]
)
def test_wrong_values_are_errors_of_the_text(text: str) -> None:
    with pytest.raises(
        YamlError, match=r"not YAML: .* is not a valid (bool|int|float|timestamp).* line 1, column 1"
    ):
        load(text)


@pytest.mark.parametrize("text", ["[1", "*nobody", "a: \0", "\udcff", "!!python/object:os.system x"])
def test_what_is_not_yaml(text: str) -> None:
    with pytest.raises(YamlError, match=r"^not YAML: "):
        load(text)


def test_bytes_of_an_argument_that_are_not_utf8() -> None:
    with pytest.raises(YamlError, match=r"not YAML: not UTF-8 text at position 3$"):
        load("a: \udcff")


def test_errors_do_not_name_a_file_that_the_user_does_not_know() -> None:
    with pytest.raises(YamlError, match=r"control characters are not allowed at position 3$"):
        load("a: \0")


def test_the_place_of_a_mistake() -> None:
    with pytest.raises(YamlError) as caught:
        load("a: 1\nb: }")
    assert (caught.value.line, caught.value.column) == (2, 4)


def test_aliases_and_merges_that_people_write_are_read() -> None:
    text = "base: &base {p: 1, i: 2}\nleft: {<<: *base, i: 3}\nright: *base\n"
    assert load(text) == {"base": {"p": 1, "i": 2}, "left": {"p": 1, "i": 3}, "right": {"p": 1, "i": 2}}
    assert has_alias(text)
    assert not has_alias("a: '*b'")


def test_long_and_flat_is_read() -> None:
    assert len(load(f"[{'[1, 2], ' * 10_000}]")) == 10_000


def test_the_limit_of_values() -> None:
    # Longer texts count as several values, so this stays quick.
    value = "x" * 64 * 1000
    assert load_all_sizes(f"[{f'{value}, ' * (MAX_VALUES // 1001 - 1)}]") == [MAX_VALUES // 1001 - 1]
    with pytest.raises(YamlError, match="more than 1000000 values"):
        load(f"[{f'{value}, ' * (MAX_VALUES // 1001 + 1)}]")


def test_the_limit_of_aliases() -> None:
    text = "a: &a [1, 2, 3]\nb: [{}]"
    allowed = MAX_ALIASED_VALUES // 4
    assert len(load(text.format("*a, " * allowed))["b"]) == allowed
    with pytest.raises(YamlError, match="aliases"):
        load(text.format("*a, " * (allowed + 1)))


def test_the_limit_of_merges() -> None:
    text = PADDING + "a: &a {{x: 1}}\nb: {{{}}}"
    assert load(text.format("<<: *a, " * MAX_MERGES))["b"] == {"x": 1}
    with pytest.raises(YamlError, match="merges"):
        load(text.format("<<: *a, " * (MAX_MERGES + 1)))


def test_the_limit_of_levels() -> None:
    assert load(PADDING + "[" * MAX_NESTING + "]" * MAX_NESTING)
    with pytest.raises(YamlError, match="more than 1000 levels"):
        load(PADDING + "[" * (MAX_NESTING + 1) + "]" * (MAX_NESTING + 1))
    with pytest.raises(YamlError, match="more than 1000 levels"):
        load(f"a: &a {'[' * 600}{']' * 600}\nb: {'[' * 600}*a{']' * 600}")


def test_the_limit_of_numbers() -> None:
    assert load("9" * MAX_NUMBER_CHARS) == 10**MAX_NUMBER_CHARS - 1
    assert load("0." + "3" * (MAX_NUMBER_CHARS - 2)) == pytest.approx(1 / 3)
    assert load(f"'{'9' * 1000}'") == "9" * 1000
    assert load("1:30") == 90
    assert math.isinf(load(".inf"))


def test_each_document_has_limits_of_its_own() -> None:
    text = "a: &a [1, 2, 3]\nb: [" + "*a, " * (MAX_ALIASED_VALUES // 5) + "]\n"
    assert load_all_sizes(f"{text}---\n{text}") == [2, 2]


def load_all_sizes(text: str) -> list[int]:
    return [len(document) for document in load_all(text)]


def test_no_other_module_calls_a_loader() -> None:
    root = Path(rostether.__file__).parent
    for path in root.rglob("*.py"):
        text = path.read_text()
        if path.name == "bounded_yaml.py" or "yaml" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            if (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id == "yaml"
            ):
                readers = ("load", "load_all", "safe_load", "safe_load_all", "parse", "compose", "scan")
                assert node.attr not in readers, f"{path} uses yaml.{node.attr}: use bounded_yaml"
