"""Parameters as YAML, read and written as rosparam does: several documents, `_ns`, rad() and deg()."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any

import yaml

from rostether.cli.expression import compile_expression
from rostether.errors import ConfigError
from rostether.names.graph_name import join

DOCUMENT_END = "...\n"
NAMESPACE_KEY = "_ns"
"""A key of a document that says into which namespace it is loaded."""


class _Loader(yaml.SafeLoader):
    """YAML with angles: `rad(pi/2)`, `deg(90)`, `!radians pi/2`, `!degrees 90`."""


class _Dumper(yaml.SafeDumper):
    """YAML of what XML-RPC carries: its dates are texts of a class of their own."""


_Dumper.add_multi_representer(str, lambda dumper, text: dumper.represent_str(str(text)))


def _radians(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> float:
    text = str(loader.construct_scalar(node)).strip()
    expression = text[4:-1] if text.startswith("rad(") else text
    value = compile_expression(expression, frozenset(("pi",)), source=text)({"pi": math.pi})
    if not isinstance(value, int | float):
        raise ConfigError(f"{text!r} is no angle; write rad(pi/2)")
    return float(value)


def _degrees(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> float:
    text = str(loader.construct_scalar(node)).strip()
    number = text[4:-1] if text.startswith("deg(") else text
    try:
        return math.radians(float(number))
    except ValueError:
        raise ConfigError(f"{text!r} is no angle; write deg(90)") from None


for _tag, _construct, _prefix in (("!radians", _radians, "rad"), ("!degrees", _degrees, "deg")):
    _Loader.add_constructor(_tag, _construct)
    _Loader.add_implicit_resolver(_tag, re.compile(rf"^{_prefix}\([^\)]*\)$"), [_prefix[0]])


def parse_value(text: str, source: str) -> Any:
    """Return one value; an empty text is the empty string. Raises ConfigError."""
    return _guarded(lambda: yaml.load(text, Loader=_Loader), source) if text else ""  # noqa: S506


def parse_documents(text: str, namespace: str, source: str) -> Iterator[tuple[str, Any]]:
    """Yield each document with the namespace it goes into. Raises ConfigError naming `source`."""
    documents = _guarded(lambda: list(yaml.load_all(text, Loader=_Loader)), source)
    for document in documents:
        if isinstance(document, dict) and NAMESPACE_KEY in document:
            below = document.pop(NAMESPACE_KEY)
            yield join(namespace, str(below)) if below else namespace, document
        elif document is not None:
            yield namespace, document


def leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield what to set: setting a mapping changes what it names and leaves the rest of the tree."""
    if not isinstance(value, dict):
        yield name, value
        return
    for key, each in value.items():
        if not isinstance(key, str):
            raise ConfigError(f"{name}: the key {key!r} is no text; put it in quotes to use it as a name")
        yield from leaves(join(name, key), each)


def dump(value: Any) -> str:
    """Return a value or tree in YAML, as a document; after a lone plain scalar follows `...`."""
    text: str = yaml.dump(value, Dumper=_Dumper)
    return text


def pretty_lines(tree: dict[str, Any], indent: str = "") -> Iterator[str]:
    """Yield a tree's lines as `rosparam get -p` prints them: strings without quotes, not YAML-safe."""
    for key in sorted(tree):
        value = tree[key]
        if isinstance(value, dict):
            yield f"{indent}{key}:"
            yield from pretty_lines(value, indent + "  ")
        elif isinstance(value, str) and "\n" in value:
            yield f"{indent}{key}: |"
            yield from (f"{indent}  {line}" for line in value.split("\n"))
        elif isinstance(value, str):
            yield f"{indent}{key}: {value}"
        else:
            yield f"{indent}{key}: {dump(value).removesuffix(DOCUMENT_END).rstrip()}"


def _guarded(load: Any, source: str) -> Any:
    try:
        return load()
    except yaml.YAMLError as error:
        problem = " ".join(str(getattr(error, "problem", None) or error).split())
        mark = getattr(error, "problem_mark", None)
        place = f":{mark.line + 1}:{mark.column + 1}" if mark is not None else ""
        raise ConfigError(f"{source}{place}: this is not YAML: {problem}") from None
