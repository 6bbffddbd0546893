"""`rostether param set` and `param load`: parameters from the command line and from YAML files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.completions import complete_params
from rostether.cli.access.options import master_option
from rostether.cli.access.refusals import refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.param.group import verbose_option
from rostether.cli.shell.input_files import read_bytes, read_text
from rostether.cli.shell.output import warn, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb
from rostether.errors import ConfigError, InvalidNameError

if TYPE_CHECKING:
    from rostether.graph.ports import ParamValue

_NEGATIVE_NUMBERS = {"ignore_unknown_options": True}
"""`param set /x -5` sets minus five."""


@click.command(
    "set",
    cls=Verb,
    context_settings=_NEGATIVE_NUMBERS,
    examples="""
    rostether param set /blink_hz 2.5
    rostether param set /arm "{joints: [0.1, deg(90)], name: left}"
    rostether param set /robot_description -t robot.urdf
    rostether param set --ros2 /board gain 0.5
    """,
)
@click.argument("name", shell_complete=complete_params)
@click.argument("value", required=False)
@click.argument("more", nargs=-1, metavar="[VALUE]...")
@click.option(
    "-t", "--textfile", type=click.Path(path_type=Path), help="Set it to the contents of a text file."
)
@click.option("-b", "--binfile", type=click.Path(path_type=Path), help="Set it to the bytes of a file.")
@verbose_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def set_param(
    name: str,
    value: str | None,
    more: tuple[str, ...],
    textfile: Path | None,
    binfile: Path | None,
    verbose: bool,
    master: str | None,
) -> None:
    """Set a parameter to a value in YAML.

    A mapping sets each parameter it names and leaves the others of the namespace as they are.
    With --ros2, type NODE NAME VALUE.
    """
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.param import ros2_param as ros2

        refuse_ros1_only(textfile=textfile, binfile=binfile, verbose=verbose, master=master)
        ros2.set_params(middleware, (name, *((value,) if value is not None else ()), *more))
        return
    refuse_ros2_only(more=more)
    from rostether.param_yaml import looks_like_number, parse_value

    if (value is not None) + (textfile is not None) + (binfile is not None) != 1:
        raise click.UsageError("give a value, or a file with -t or -b")
    content: Any
    if textfile is not None:
        content = read_text(textfile)
    elif binfile is not None:
        content = read_bytes(binfile)
    else:
        assert value is not None
        content = parse_value(value, "value")
        if content == {}:
            warn(
                f"nothing to set: an empty mapping names nothing; `rostether param delete {name}` empties it"
            )
        elif looks_like_number(content):
            warn(f"{value} is a text in YAML; a number has a dot and a sign there, as 1.0e-3 and 1.0e+3")
    run(_store([(name, content)], verbose, master))


@click.command(
    "load",
    cls=Verb,
    examples="rostether param load settings.yaml\nrostether param load settings.yaml /board",
)
@click.argument("file", type=click.Path(path_type=Path, allow_dash=True))
@click.argument("namespace", default="")
@verbose_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def load(file: Path, namespace: str, verbose: bool, master: str | None) -> None:
    """Set the parameters of a YAML file (- is stdin), in a namespace if one is given.

    With --ros2, type NODE FILE.
    """
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.param import ros2_param as ros2

        refuse_ros1_only(verbose=verbose, master=master)
        if not namespace:
            raise click.UsageError("type NODE FILE")
        ros2.load(middleware, str(file), Path(namespace))
        return
    from rostether.param_yaml import parse_documents

    text = read_text(file)
    run(_store(list(parse_documents(text, namespace, str(file))), verbose, master))


async def _store(values: list[tuple[str, Any]], verbose: bool, master: str | None) -> None:
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.param.access import param_name
    from rostether.param_yaml import leaves

    environment = read_environment(master)
    settings: list[tuple[str, ParamValue]] = []
    for name, value in values:
        full_name = param_name(name, environment)
        if full_name == "/" and not isinstance(value, dict):
            raise ConfigError("/ can only be set to a mapping of names to values")
        # All of them, before the first is set: a mistake in a file sets nothing.
        settings += leaves(full_name, value)
    _warn_of_illegal([name for name, _ in settings])
    async with master_client(environment) as client:
        for name, value in settings:
            await client.set_param(name, value)
            if verbose:
                write_line(f"set parameter [{name}] to [{value!s}]")


def _warn_of_illegal(names: list[str]) -> None:
    from rostether.names.graph_name import validate_name

    for name in names:
        try:
            validate_name(name)
        except InvalidNameError as error:
            warn(f"warning: {error}; it is set, but roscpp nodes refuse such names")
            return
