"""Parameters as YAML, read and written as rosparam does: several documents, `_ns`, rad() and deg()."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import yaml

from rostether.bounded_yaml import YamlError, load, load_all, safe_loader
from rostether.errors import ConfigError
from rostether.expression.compiler import compile_expression
from rostether.graph.ports import ParamValue
from rostether.names.graph_name import is_private, join
from rostether.xmlrpc.values import MAX_INT, MIN_INT

T = TypeVar("T")

# The limit of XML-RPC documents; YAML's anchors can be nested without a limit.
MAX_NESTING = 100

# The limit of all documents in one text. A robot description takes 100 KB; a master keeps it in memory.
MAX_FILE_CHARS = 16 << 20

DOCUMENT_END = "...\n"
# The key of a document for the namespace that it is loaded into.
NAMESPACE_KEY = "_ns"


_Safe: Any = safe_loader()


class _Loader(_Safe):  # type: ignore[misc]
    """YAML with angles: `rad(pi/2)`, `deg(90)`, `!radians pi/2`, `!degrees 90`."""


_NEARLY_FLOAT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")


class _Dumper(yaml.SafeDumper):
    """YAML for values of XML-RPC, whose dates are texts of a separate class."""


_Dumper.add_multi_representer(str, lambda dumper, text: dumper.represent_str(str(text)))


def _radians(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> float:
    text = str(loader.construct_scalar(node)).strip()
    expression = text[4:-1] if text.startswith("rad(") else text
    value = compile_expression(expression, frozenset(("pi",)), source=text)({"pi": math.pi})
    if not isinstance(value, int | float):
        raise ConfigError(f"{text!r} is not an angle; write rad(pi/2)")
    return float(value)


def _degrees(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> float:
    text = str(loader.construct_scalar(node)).strip()
    number = text[4:-1] if text.startswith("deg(") else text
    try:
        return math.radians(float(number))
    except ValueError:
        raise ConfigError(f"{text!r} is not an angle; write deg(90)") from None


for _tag, _construct, _prefix in (("!radians", _radians, "rad"), ("!degrees", _degrees, "deg")):
    _Loader.add_constructor(_tag, _construct)
    _Loader.add_implicit_resolver(_tag, re.compile(rf"^{_prefix}\([^\)]*\)$"), [_prefix[0]])


def parse_value(text: str, source: str) -> Any:
    """Return one value; an empty text is the empty string. Raises ConfigError."""
    return parse_single_document(text, source) if text else ""


def parse_documents(text: str, namespace: str, source: str) -> Iterator[tuple[str, Any]]:
    """Yield each document with the namespace it goes into. Raises ConfigError naming `source`."""
    if len(text) > MAX_FILE_CHARS:
        raise ConfigError(f"{source}: longer than {MAX_FILE_CHARS} characters; split the file")
    for document in _guarded(lambda: list(load_all(text, _Loader)), source):
        if isinstance(document, dict) and NAMESPACE_KEY in document:
            below = document.pop(NAMESPACE_KEY)
            yield join(namespace, str(below)) if below else namespace, document
        elif document is not None:
            yield namespace, document


def parse_single_document(text: str, source: str) -> Any:
    """Return the value of one document; None for an empty one. Raises ConfigError naming `source`."""
    return _guarded(lambda: load(text, _Loader), source)


def leaves(name: str, value: Any, nesting: int = 0) -> Iterator[tuple[str, ParamValue]]:
    """Yield each parameter that a value loaded from YAML sets, with its full name.

    A mapping changes what it names and leaves the rest of the tree; a key with a leading slash is a full
    name. Raises ConfigError, which names a valid form, for a value that no parameter can have.
    """
    if not isinstance(value, dict):
        yield name, _checked(name, value, nesting)
        return
    if nesting > MAX_NESTING:
        raise ConfigError(f"parameters are nested deeper than {MAX_NESTING} levels; flatten them")
    for key, each in value.items():
        if not isinstance(key, str):
            raise ConfigError(
                f"{name}: the key {key!r} is not a string; put it in quotes to use it as a name"
            )
        if is_private(key):
            raise ConfigError(f"{name}: the key {key!r} is private; write the node's name instead of ~")
        yield from leaves(join(name, key), each, nesting + 1)


def _checked(name: str, value: Any, nesting: int) -> ParamValue:
    """Return a value that a parameter can have."""
    if nesting > MAX_NESTING:
        raise ConfigError(f"parameter {name} is nested deeper than {MAX_NESTING} levels; flatten it")
    if isinstance(value, list):
        return [_checked(name, each, nesting + 1) for each in value]
    if isinstance(value, dict):
        return {str(key): _checked(name, each, nesting + 1) for key, each in value.items()}
    if isinstance(value, int) and not MIN_INT <= value <= MAX_INT:
        raise ConfigError(
            f"parameter {name}: {value} needs more than the 32 bits of a parameter; "
            f"write {value}.0 for a float or '\"{value}\"' for a text"
        )
    if isinstance(value, bool | int | float | str | bytes):
        return value
    if value is None:
        raise ConfigError(
            f"parameter {name} has no value (YAML reads it as null); indent the lines that belong to it, "
            "or omit it"
        )
    raise ConfigError(f"parameter {name}: YAML reads {value} as a {type(value).__name__}; put it in quotes")


def looks_like_number(value: object) -> bool:
    """Return whether a text looks like a number that YAML reads as text, such as `1e-3`, which has no dot."""
    return isinstance(value, str) and _NEARLY_FLOAT.fullmatch(value) is not None


def dump(value: Any) -> str:
    """Return a value or tree as a YAML document, which ends with `...` if it is a single plain scalar."""
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


def _guarded(read: Callable[[], T], source: str) -> T:
    try:
        return read()
    except YamlError as error:
        location = f":{error.line}:{error.column}" if error.line else ""
        raise ConfigError(f"{source}{location}: this is {error.problem}") from None
