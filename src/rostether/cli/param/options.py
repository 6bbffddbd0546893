"""The options of `rostether param`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

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
