"""The interface of `rostether param` to a graph."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from rostether.cli.access.completions import complete_params
from rostether.cli.shell.option_group import PATH, add_flag, argument, flag, option, shared
from rostether.cli.shell.output import json_option

verbose_option = add_flag("-v --verbose", "Report each step.")


@dataclass(frozen=True, slots=True)
class ParamListing:
    """The options of `param list`."""

    namespace: str = argument(default="/", shell_complete=complete_params)
    with_hidden: bool = flag("--include-hidden-nodes", "With --ros2, include hidden nodes.")
    with_types: bool = flag("--param-type", "With --ros2, show types.")
    prefixes: tuple[str, ...] = option(
        "--param-prefixes PREFIX", "With --ros2, only parameters below PREFIX.", multiple=True
    )
    as_json: bool = shared(json_option, False)


@dataclass(frozen=True, slots=True)
class GetOptions:
    """The options of `param get`."""

    pretty: bool = flag("-p", "Print without quotes; not YAML-safe.")
    hide_type: bool = flag("--hide-type", "With --ros2, print only the value.")
    verbose: bool = shared(verbose_option, False)
    as_json: bool = shared(json_option, False)


@dataclass(frozen=True, slots=True)
class SetOptions:
    """The options of `param set`."""

    textfile: Path | None = option(
        "-t --textfile", "Set the parameter to the contents of a text file.", type=PATH
    )
    binfile: Path | None = option("-b --binfile", "Set the parameter to the bytes of a file.", type=PATH)
    verbose: bool = shared(verbose_option, False)


class Params(Protocol):
    """The parameters of one graph. Each method is a whole command and raises RostetherError, UsageError.

    A parameter of ROS 2 is given as a node and a name, or as both in one full name.
    """

    def list_params(self, wanted: ParamListing) -> None:
        """Print the names of parameters."""

    def get(self, name: str, parameter: str | None, options: GetOptions) -> None:
        """Print a parameter."""

    def set_param(self, words: tuple[str, ...], options: SetOptions) -> None:
        """Set a parameter; `words` are NAME VALUE, or with ROS 2 NODE NAME VALUE."""

    def delete(self, name: str, parameter: str | None, *, verbose: bool) -> None:
        """Delete a parameter."""

    def describe(self, node: str, names: tuple[str, ...], *, as_json: bool) -> None:
        """Print type, limits and description of a node's parameters."""

    def dump(self, file: Path | None, namespace: str, /, *, verbose: bool) -> None:
        """Write parameters as YAML; with ROS 2, `file` is the node."""

    def load(self, file: Path, namespace: str, /, *, verbose: bool) -> None:
        """Set the parameters of a YAML file; with ROS 2, `file` is the node and `namespace` the file."""
