"""ROS command-line arguments: remappings `a:=b`, private parameters `_a:=1`, special names `__name:=n`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from msgspec import Struct, field

from rostether.bounded_yaml import YamlError, load
from rostether.errors import ConfigError
from rostether.names.graph_name import is_legal_name

ASSIGNMENT = ":="
SPECIAL_KEYS = frozenset({"__name", "__ns", "__log", "__ip", "__hostname", "__master"})

_REMAP_ARGUMENT = re.compile(r"[~/A-Za-z_][A-Za-z0-9_/]*:=.*", re.DOTALL)


class Arguments(Struct, frozen=True):
    """The arguments of a command line; the last remapping or parameter of a name counts.

    `remappings` are unresolved (see `names.graph_name.resolve_remappings`). `private_params` are the values
    read as YAML, by their names without the underscore. `special` has keys like `__name`, `rest` the other
    arguments in order.
    """

    remappings: dict[str, str] = field(default_factory=dict)
    private_params: dict[str, Any] = field(default_factory=dict)
    special: dict[str, str] = field(default_factory=dict)
    rest: list[str] = field(default_factory=list)


def parse_arguments(argv: Iterable[str]) -> Arguments:
    """Classify the arguments as rospy does; one with an empty side (`a:=`) is dropped.

    Raises ConfigError for a value that is not YAML, a side that is not a name, or an unknown special key.
    """
    arguments = Arguments()
    for argument in argv:
        if not _REMAP_ARGUMENT.fullmatch(argument):
            arguments.rest.append(argument)
            continue
        key, _, value = (part.strip() for part in argument.partition(ASSIGNMENT))
        if not key or not value:
            continue
        if key.startswith("__"):
            if key not in SPECIAL_KEYS:
                known = ", ".join(f"{name}:=" for name in sorted(SPECIAL_KEYS))
                raise ConfigError(f"{argument!r}: {key} is not a ROS argument; known: {known}")
            arguments.special[key] = value
        elif key.startswith("_") and len(key) > 1:
            arguments.private_params[key[1:]] = _yaml_value(argument, value)
        elif not is_legal_name(key) or not is_legal_name(value):
            wrong = value if is_legal_name(key) else key
            raise ConfigError(
                f"{argument!r}: {wrong!r} is not a ROS name; a remapping is written from:=to, a"
                " private parameter _name:=value"
            )
        else:
            arguments.remappings[key] = value
    return arguments


def _yaml_value(argument: str, text: str) -> Any:
    try:
        return load(text)
    except YamlError as error:
        raise ConfigError(f"{argument!r}: the value is {error}; put quotes around text") from None
