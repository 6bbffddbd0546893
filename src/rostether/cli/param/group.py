"""`rostether param`: reading and writing parameters, as rosparam does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rostether.cli.access.completions import complete_params
from rostether.cli.access.options import master_option
from rostether.cli.access.refusals import refuse_ros1_only, refuse_ros2_only
from rostether.cli.access.ros2_daemon_options import daemon_habits
from rostether.cli.access.ros_choice import chosen_ros2, ros1_option, ros2_option
from rostether.cli.shell.output import json_option, one_line, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import LazyGroup, Verb, VerbEntry
from rostether.errors import UnknownNameError

_HERE = "rostether.cli.param.group:"
_VERBS = {
    "list": VerbEntry(f"{_HERE}list_params", "List the names of parameters."),
    "get": VerbEntry(f"{_HERE}get", "Print a parameter, or all of a namespace."),
    "set": VerbEntry("rostether.cli.param.store:set_param", "Set a parameter."),
    "delete": VerbEntry(f"{_HERE}delete", "Delete a parameter, or all of a namespace."),
    "describe": VerbEntry(
        "rostether.cli.param.describe:describe", "Show what a ROS 2 node says of its parameters."
    ),
    "dump": VerbEntry(f"{_HERE}dump_params", "Write parameters to a YAML file."),
    "load": VerbEntry("rostether.cli.param.store:load", "Set the parameters of a YAML file."),
}

verbose_option = click.option("-v", "--verbose", is_flag=True, help="Say what is done.")


@click.group(
    cls=LazyGroup,
    verbs=_VERBS,
    examples="""
    rostether param set /blink_hz 2.5
    rostether param get /blink_hz
    rostether param dump settings.yaml
    rostether param get --ros2 /board gain
    """,
)
def param() -> None:
    """Read and write the parameters of a ROS graph."""


@click.command("list", cls=Verb, examples="rostether param list\nrostether param list /board")
@click.argument("namespace", default="/", shell_complete=complete_params)
@click.option("--include-hidden-nodes", "with_hidden", is_flag=True, help="With --ros2, of hidden nodes too.")
@click.option("--param-type", "with_types", is_flag=True, help="With --ros2, show types.")
@click.option(
    "--param-prefixes", "prefixes", multiple=True, metavar="PREFIX", help="With --ros2, those below PREFIX."
)
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def list_params(
    namespace: str,
    with_hidden: bool,
    with_types: bool,
    prefixes: tuple[str, ...],
    as_json: bool,
    master: str | None,
) -> None:
    """List the names of parameters, of all or of a namespace; with --ros2, of a node."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.param import ros2_param as ros2

        refuse_ros1_only(master=master)
        ros2.list_params(
            middleware,
            None if namespace == "/" else namespace,
            with_hidden=with_hidden,
            with_types=with_types,
            prefixes=prefixes,
            as_json=as_json,
        )
        return
    refuse_ros2_only(with_hidden=with_hidden, with_types=with_types, prefixes=prefixes)
    for name in run(_names_below(namespace, master)):
        if as_json:
            write_json({"name": name})
        else:
            write_line(one_line(name))


async def _names_below(namespace: str, master: str | None) -> list[str]:
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.param.access import param_name

    environment = read_environment(master)
    prefix = param_name(namespace, environment).rstrip("/") + "/"
    async with master_client(environment) as client:
        return sorted(name for name in await client.param_names() if name.startswith(prefix))


@click.command("get", cls=Verb, examples="rostether param get /rosdistro\nrostether param get -p /")
@click.argument("name", shell_complete=complete_params)
@click.argument("parameter", metavar="[NAME]", required=False)
@click.option("-p", "pretty", is_flag=True, help="Print without quotes; not YAML-safe.")
@click.option("--hide-type", is_flag=True, help="With --ros2, print the value alone.")
@verbose_option
@json_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def get(
    name: str,
    parameter: str | None,
    pretty: bool,
    hide_type: bool,
    verbose: bool,
    as_json: bool,
    master: str | None,
) -> None:
    """Print a parameter, or all parameters of a namespace, in YAML; with --ros2, type NODE NAME."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.param import ros2_param as ros2

        refuse_ros1_only(pretty=pretty, verbose=verbose, master=master)
        ros2.get(middleware, name, parameter, hide_type=hide_type, as_json=as_json)
        return
    refuse_ros2_only(parameter=parameter, hide_type=hide_type)
    from rostether.param_yaml import DOCUMENT_END, dump, pretty_lines

    full_name, value = run(_fetch(name, master))
    if verbose:
        write_line(f"getting parameter [{full_name}]")
    if as_json:
        write_json({"name": full_name, "value": _plain(value)})
    elif pretty and isinstance(value, dict):
        for line in pretty_lines(value):
            write_line(line)
    elif pretty and isinstance(value, str):
        write_line(value)
    else:
        # As rosparam prints it: whatever has no document end of its own is followed by an empty line.
        write_line(dump(value).removesuffix(f"\n{DOCUMENT_END}"))


async def _fetch(name: str, master: str | None) -> tuple[str, Any]:
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.param.access import not_set, param_name

    environment = read_environment(master)
    full_name = param_name(name, environment)
    async with master_client(environment) as client:
        try:
            return full_name, await client.get_param(full_name)
        except UnknownNameError:
            raise await not_set(client, full_name) from None


def _plain(value: Any) -> Any:
    """Return a value as JSON can hold it; bytes stay, `write_json` knows them."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_plain(each) for each in value]
    if isinstance(value, float):
        from rostether.serde.plain_form import plain_value

        return plain_value(value)
    return value


@click.command("delete", cls=Verb, examples="rostether param delete /blink_hz")
@click.argument("name", shell_complete=complete_params)
@click.argument("parameter", metavar="[NAME]", required=False)
@verbose_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def delete(name: str, parameter: str | None, verbose: bool, master: str | None) -> None:
    """Delete a parameter, or all parameters of a namespace; with --ros2, type NODE NAME."""
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.param import ros2_param as ros2

        refuse_ros1_only(verbose=verbose, master=master)
        ros2.delete(middleware, name, parameter)
        return
    refuse_ros2_only(parameter=parameter)
    full_name = run(_delete(name, master))
    if verbose:
        write_line(
            "deleted ENTIRE parameter server" if full_name == "/" else f"deleted parameter [{full_name}]"
        )


async def _delete(name: str, master: str | None) -> str:
    from rostether.cli.access.ros1_access import master_client, read_environment
    from rostether.cli.param.access import not_set, param_name

    environment = read_environment(master)
    full_name = param_name(name, environment)
    async with master_client(environment) as client:
        if full_name == "/":
            # The root always has a value: deleting it means emptying it.
            await client.set_param("/", {})
            return full_name
        try:
            await client.delete_param(full_name)
        except UnknownNameError:
            raise await not_set(client, full_name) from None
    return full_name


@click.command("dump", cls=Verb, examples="rostether param dump settings.yaml\nrostether param dump - /board")
@click.argument("file", required=False, type=click.Path(path_type=Path, allow_dash=True))
@click.argument("namespace", default="")
@verbose_option
@master_option
@ros1_option
@ros2_option
@daemon_habits
def dump_params(file: Path | None, namespace: str, verbose: bool, master: str | None) -> None:
    """Write parameters to a YAML file; without a file, or with -, to stdout.

    With --ros2, type the node instead of the file: its parameters go to stdout.
    """
    if (middleware := chosen_ros2()) is not None:
        from rostether.cli.param import ros2_param as ros2

        refuse_ros1_only(namespace=namespace, verbose=verbose, master=master)
        if file is None:
            raise click.UsageError("type the node whose parameters are wanted")
        ros2.dump(middleware, str(file))
        return
    from rostether.param_yaml import dump

    if verbose:
        write_line(f"dumping namespace [{namespace}] to file [{file}]")
    text = dump(run(_fetch(namespace, master))[1])
    if file is None or str(file) == "-":
        write_line(text.removesuffix("\n"))
    else:
        file.write_text(text, "utf-8")
