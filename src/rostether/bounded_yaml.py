"""Reads YAML from files and command lines within limits: the only place that calls a YAML loader.

A YAML text can be much smaller than its value. Aliases (`*name`) and merges (`<<`) repeat a part, `1:1:1`
is a number in base 60, and brackets can be nested without a limit. So the events of the text are counted
before any value is made; an alias costs as much as the part that it repeats.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, Final, TypeVar

from msgspec import Struct

T = TypeVar("T")

# The characters of texts that count as MAX_VALUES values, see _CHARS_PER_VALUE.
MAX_TEXT_CHARS: Final = 64 << 20

# The values of one document, with aliases expanded; each takes 350 bytes. A color image of 640 x 480 has
# 921,600 values.
MAX_VALUES: Final = 1_000_000

# The values that aliases and merges add. Files that people write repeat about a hundred.
MAX_ALIASED_VALUES: Final = 200_000

# Each `<<` moves the rest of its mapping: 300,000 in one mapping take minutes.
MAX_MERGES: Final = 1_000

# Far deeper than any message or parameter; libyaml recurses in C and crashes at 20,000 levels.
MAX_NESTING: Final = 1_000

# A double written out has 325 characters. The time for `1:1:1:...` grows with the square of its length.
MAX_NUMBER_CHARS: Final = 400

# A longer text counts as more values, so that repeated long texts are also bounded.
_CHARS_PER_VALUE: Final = 64

# A text as short as this stays below the limits unless it has an alias.
_HARMLESS_CHARS: Final = 10_000

# PyYAML raises these for values such as `2001-99-99`, `!!bool x` and `!!timestamp x`.
_WRONG_VALUES: Final = (ValueError, ArithmeticError, LookupError, AttributeError, TypeError)


class YamlError(ValueError):
    """A text is not YAML or exceeds a limit.

    `problem` continues "this is ...", for example "not YAML: found unexpected end of stream".
    `line` and `column` count from 1; 0 is unknown.
    """

    def __init__(self, problem: str, mark: Any = None) -> None:
        self.problem = problem
        self.line = mark.line + 1 if mark is not None else 0
        self.column = mark.column + 1 if mark is not None else 0
        super().__init__(f"{problem} at line {self.line}, column {self.column}" if self.line else problem)


@cache
def safe_loader() -> Any:
    """Return the loader class: YAML's plain types, with numbers of bounded length."""
    # Imported here, because most commands never read YAML, and the import takes 10 ms.
    import yaml

    base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    loader: Any = type("Loader", (base,), {})

    def checked(kind: str, construct: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        def construct_checked(self: Any, node: Any) -> Any:
            text = self.construct_scalar(node)
            if len(text) > MAX_NUMBER_CHARS:
                problem = (
                    f"a number has {len(text)} characters (at most {MAX_NUMBER_CHARS}); put it in quotes"
                )
                raise YamlError(f"too large as YAML: {problem}", node.start_mark)
            try:
                return construct(self, node)
            except _WRONG_VALUES:
                raise YamlError(
                    f"not YAML: {text!r} is not a valid {kind}; put it in quotes", node.start_mark
                ) from None

        return construct_checked

    for kind in ("bool", "int", "float", "timestamp"):
        loader.add_constructor(
            f"tag:yaml.org,2002:{kind}", checked(kind, getattr(base, f"construct_yaml_{kind}"))
        )
    return loader


def load(text: str, loader: Any = None) -> Any:
    """Return the value of a text's only document, None for an empty one. Raises YamlError.

    `loader` is a subclass of `safe_loader()`.
    """
    import yaml

    used = loader or safe_loader()
    _translated(lambda: _check_size(text, used))
    return _translated(lambda: yaml.load(text, Loader=used))  # noqa: S506 - a safe one


def load_all(text: str, loader: Any = None) -> Iterator[Any]:
    """Yield the value of each document. Raises YamlError, for limits before the first value."""
    import yaml

    used = loader or safe_loader()
    _translated(lambda: _check_size(text, used))
    documents = yaml.load_all(text, Loader=used)
    end = object()
    while (document := _translated(lambda: next(documents, end))) is not end:
        yield document


def has_alias(text: str) -> bool:
    """Return whether a text uses an alias. Raises YamlError."""
    import yaml

    events = yaml.parse(text, Loader=safe_loader())
    return "*" in text and _translated(lambda: any(isinstance(event, yaml.AliasEvent) for event in events))


def _translated(read: Callable[[], T]) -> T:
    import yaml

    try:
        return read()
    except YamlError:
        raise
    except yaml.YAMLError as error:
        problem = " ".join(str(getattr(error, "problem", None) or error).split())
        problem = problem.replace(' in "<unicode string>",', " at")
        # libyaml has the same limit since 0.2.6, and may reach it first.
        if problem == "exceeded maximum nesting depth":
            raise _too_large(
                "levels", MAX_NESTING, "flatten it", getattr(error, "problem_mark", None)
            ) from None
        if problem == "found character that cannot start any token":
            problem += "; indent with spaces, not tabs, and quote texts that begin with @, % or `"
        raise YamlError(f"not YAML: {problem}", getattr(error, "problem_mark", None)) from None
    except RecursionError:
        raise YamlError("too large as YAML: it is nested too deeply") from None
    except UnicodeEncodeError as error:
        # libyaml reads UTF-8; an argument of a command may contain other bytes.
        raise YamlError(f"not YAML: not UTF-8 text at position {error.start}") from None
    except _WRONG_VALUES as error:
        raise YamlError(f"not YAML: {' '.join(str(error).split())}") from None


def _check_size(text: str, loader: Any) -> None:
    if len(text) > MAX_TEXT_CHARS:
        raise YamlError(f"too large as YAML: it has more than {MAX_TEXT_CHARS >> 20} MiB; split it")
    if len(text) <= _HARMLESS_CHARS and "*" not in text:
        return
    import yaml

    sizes = _Sizes()
    for event in yaml.parse(text, Loader=loader):
        if isinstance(event, yaml.DocumentStartEvent):
            sizes = _Sizes()
        elif isinstance(event, yaml.CollectionStartEvent):
            sizes.open(event)
        elif isinstance(event, yaml.CollectionEndEvent):
            sizes.close()
        elif isinstance(event, yaml.ScalarEvent):
            sizes.add_scalar(event)
        elif isinstance(event, yaml.AliasEvent):
            sizes.add_alias(event)
        sizes.check(event)


class _Sizes:
    """The counts of one document so far. All methods raise YamlError."""

    def __init__(self) -> None:
        # The document and the collections that are open, innermost last.
        self._parts = [_Part()]
        self._anchors: dict[str | None, _Part] = {}
        self._aliased_count = 0
        self._merge_count = 0

    def open(self, event: Any) -> None:
        part = self._anchors[event.anchor] = _Part()
        self._parts.append(part)

    def close(self) -> None:
        part = self._parts.pop()
        part.is_open = False
        self._parts[-1].add(part)

    def add_scalar(self, event: Any) -> None:
        part = _Part(1 + len(event.value) // _CHARS_PER_VALUE, 0, is_open=False)
        self._anchors[event.anchor] = part
        self._parts[-1].add(part)
        self._merge_count += event.value == "<<"

    def add_alias(self, event: Any) -> None:
        part = self._anchors.get(event.anchor)
        if part is None:
            return
        if part.is_open:
            raise YamlError(f"endless as YAML: *{event.anchor} is inside &{event.anchor}", event.start_mark)
        self._parts[-1].add(part)
        self._aliased_count += part.values

    def check(self, event: Any) -> None:
        innermost = self._parts[-1]
        if len(self._parts) + innermost.depth > MAX_NESTING + 2:
            raise _too_large("levels", MAX_NESTING, "flatten it", event.start_mark)
        if innermost.values > MAX_VALUES:
            raise _too_large("values", MAX_VALUES, "write bytes as !!binary, or split it", event.start_mark)
        if self._aliased_count > MAX_ALIASED_VALUES:
            raise _too_large(
                "values from aliases (*name)", MAX_ALIASED_VALUES, "write fewer aliases", event.start_mark
            )
        if self._merge_count > MAX_MERGES:
            raise _too_large("merges (<<)", MAX_MERGES, "write the keys out", event.start_mark)


class _Part(Struct):
    """A value and what it contains, aliases expanded; `depth` is 0 for a number or text."""

    values: int = 1
    depth: int = 1
    is_open: bool = True

    def add(self, part: _Part) -> None:
        self.values += part.values
        self.depth = max(self.depth, part.depth + 1)


def _too_large(what: str, limit: int, remedy: str, mark: Any) -> YamlError:
    return YamlError(f"too large as YAML: it has more than {limit} {what}; {remedy}", mark)
