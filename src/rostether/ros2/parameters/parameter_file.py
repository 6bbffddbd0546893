"""Parameter files of ROS 2 (`--params-file`): initial parameters for nodes by their names.

/**:                          any node
  ros__parameters: {use_sim_time: true}
/lab/*/board:                 `*` is one part of a name, `**` any number of parts, including none
  ros__parameters:
    gains: {p: 1.5}           the parameter gains.p
lab:                          namespaces may nest
  board: {ros__parameters: {port: /dev/ttyACM0}}

If several entries set the same parameter of a node, the last one counts; later files override earlier ones.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from msgspec import Struct

from rostether.bounded_yaml import YamlError, has_alias, load, safe_loader
from rostether.errors import ConfigError, SerializationError
from rostether.graph.ports import ParamValue
from rostether.mechanisms.text import read_failure
from rostether.ros2.parameters.typed_value import NOT_SET, TypedValue, flatten, show_value

PARAMETERS_KEY = "ros__parameters"

# The largest files in use (navigation of a whole robot) are about 50 KB.
MAX_FILE_BYTES = 4 << 20

_FLOAT = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)[eE][-+]?\d+$")
_TIMESTAMP_TAG = "tag:yaml.org,2002:timestamp"


class _Entry(Struct, frozen=True):
    pattern: re.Pattern[str]
    values: dict[str, TypedValue]


class ParameterRules(Struct, frozen=True):
    """The initial parameters that files set for nodes."""

    entries: tuple[_Entry, ...] = ()

    def for_node(self, node: str) -> dict[str, ParamValue]:
        """Return the initial parameters of a node by their names with dots."""
        values: dict[str, ParamValue] = {}
        for entry in self.entries:
            if entry.pattern.fullmatch(node):
                values |= {name: typed.value for name, typed in entry.values.items()}
        return values


def read_parameter_files(paths: Iterable[Path]) -> ParameterRules:
    """Read files; later ones override earlier ones. Raises ConfigError with the file's name."""
    entries: list[_Entry] = []
    for path in paths:
        try:
            with path.open("rb") as file:
                data = file.read(MAX_FILE_BYTES + 1)
            if len(data) > MAX_FILE_BYTES:
                raise ConfigError(f"parameter file {path} has more than {MAX_FILE_BYTES} bytes; split it")
            text = data.decode()
        except OSError as error:
            raise ConfigError(read_failure(f"parameter file {path}", error)) from None
        except UnicodeDecodeError:
            raise ConfigError(f"parameter file {path} is not text in UTF-8; save it in UTF-8") from None
        entries += parse_parameters(text, str(path)).entries
    return ParameterRules(tuple(entries))


def parse_parameters(text: str, source: str) -> ParameterRules:
    """Read the text of a file. Raises ConfigError with `source` and the error."""
    entries: list[_Entry] = []
    try:
        if has_alias(text):
            raise ConfigError(
                f"parameter file {source} has an alias (*name), which ROS 2 does not support; "
                "repeat the value"
            )
        document = load(text, _loader())
        if document is not None:
            _collect("", document, entries)
    except YamlError as error:
        raise ConfigError(f"parameter file {source} is {error}") from None
    except RecursionError:
        raise ConfigError(f"parameter file {source} is nested too deeply; use fewer levels") from None
    except ValueError as error:
        raise ConfigError(f"parameter file {source}: {error}") from None
    return ParameterRules(tuple(entries))


def _collect(node: str, content: Any, entries: list[_Entry]) -> None:
    if not isinstance(content, dict):
        value = "nothing" if content is None else show_value(content)
        what = f"{node} holds {value}" if node else "it has no mapping"
        raise SerializationError(
            f"{what}; write node names, `{PARAMETERS_KEY}:` below each, and the parameters below that"
        )
    for key, value in content.items():
        if key == PARAMETERS_KEY and not node:
            raise SerializationError(
                f"write the name of a node above `{PARAMETERS_KEY}:`, or /** for all nodes"
            )
        if key == PARAMETERS_KEY:
            entries.append(_Entry(_pattern(node), _values(node, value)))
        else:
            _collect(f"{node}/{str(key).strip('/')}", value, entries)


def _values(node: str, content: Any) -> dict[str, TypedValue]:
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise SerializationError(f"{node}: write names with values below `{PARAMETERS_KEY}:`")
    values = flatten("", content)
    for name, value in values.items():
        if value == NOT_SET:
            raise SerializationError(f"{node}: parameter {name} has no value; add one, or remove its line")
    return values


def _pattern(node: str) -> re.Pattern[str]:
    parts = [part for part in node.split("/") if part]
    any_part = {"*": r"/\w+", "**": r"(?:/\w+)*"}
    return re.compile("".join(any_part.get(part) or re.escape(f"/{part}") for part in parts))


@cache
def _loader() -> Any:
    base = safe_loader()
    loader: Any = type(
        "Loader", (base,), {"__doc__": "YAML as rcl reads it: 1e-3 is a number, a date is text."}
    )
    loader.yaml_implicit_resolvers = {
        first: [(tag, pattern) for tag, pattern in resolvers if tag != _TIMESTAMP_TAG]
        for first, resolvers in base.yaml_implicit_resolvers.items()
    }
    loader.add_implicit_resolver("tag:yaml.org,2002:float", _FLOAT, list("-+0123456789."))
    return loader
