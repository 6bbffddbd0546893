"""`rostether param` on a ROS 1 graph, as rosparam does it."""

from __future__ import annotations

from collections.abc import Coroutine
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.access.graph_options import GraphOptions
from rostether.cli.access.options import refuse_ros2_only
from rostether.cli.access.ros1_access import master_client, read_environment, resolve
from rostether.cli.param.options import GetOptions, ParamListing, SetOptions
from rostether.cli.shell.input import read_bytes, read_text
from rostether.cli.shell.output import warn, write_file, write_json, write_line, write_result
from rostether.errors import ConfigError, InvalidNameError, UnknownNameError
from rostether.mechanisms.text import did_you_mean, escape_line
from rostether.names.graph_name import SEPARATOR, canonical, is_global
from rostether.ros1.environment import RosEnvironment
from rostether.ros1.node.master_client import MasterClient

if TYPE_CHECKING:
    from rostether.graph.ports import ParamValue


class Ros1Params:
    """The parameters of a ROS 1 graph; each method is a whole command.

    Methods that read a file do so before they return a coroutine: Ctrl-C immediately ends a read from a
    terminal only outside the event loop.
    """

    def __init__(self, graph: GraphOptions) -> None:
        self._environment = read_environment(graph)

    async def list_params(self, wanted: ParamListing) -> None:
        """Print the names of all parameters, or of those in a namespace."""
        refuse_ros2_only(
            with_hidden=wanted.with_hidden, with_types=wanted.with_types, prefixes=wanted.prefixes
        )
        prefix = param_name(wanted.namespace, self._environment).rstrip("/") + "/"
        async with master_client(self._environment) as client:
            names = sorted(name for name in await client.param_names() if name.startswith(prefix))
        for name in names:
            write_result({"name": name}, escape_line(name), as_json=wanted.as_json)

    async def get(self, name: str, parameter: str | None, options: GetOptions) -> None:
        """Print a parameter, or all parameters of a namespace, in YAML."""
        refuse_ros2_only(parameter=parameter, hide_type=options.hide_type)
        from rostether.param_yaml import DOCUMENT_END, dump, pretty_lines

        full_name, value = await _fetch(self._environment, name)
        if options.verbose:
            write_line(f"getting parameter [{full_name}]")
        if options.as_json:
            from rostether.serde.plain_form import base64_text, plain_value

            write_json({"name": full_name, "value": plain_value(value, base64_text)})
        elif options.pretty and isinstance(value, dict):
            for line in pretty_lines(value):
                write_line(line)
        elif options.pretty and isinstance(value, str):
            write_line(value)
        else:
            # As in rosparam: a value without its own document end is followed by an empty line.
            write_line(dump(value).removesuffix(f"\n{DOCUMENT_END}"))

    def set_param(self, words: tuple[str, ...], options: SetOptions) -> Coroutine[Any, Any, None]:
        """Set a parameter to a value in YAML, or to the content of a file."""
        name, *values = words
        refuse_ros2_only(more=values[1:])
        from rostether.param_yaml import looks_like_number, parse_value

        if len(values) + (options.textfile is not None) + (options.binfile is not None) != 1:
            raise click.UsageError("give a value, or a file with -t or -b")
        content: Any
        if options.textfile is not None:
            content = read_text(options.textfile)
        elif options.binfile is not None:
            content = read_bytes(options.binfile)
        else:
            content = parse_value(values[0], "value")
            if content == {}:
                warn(
                    "WARNING: an empty mapping sets nothing; "
                    f"`rostether param delete {name}` empties the namespace"
                )
            elif looks_like_number(content):
                warn(
                    f"WARNING: {values[0]} is text in YAML; an exponent needs a dot and a sign, as in 1.0e-3"
                )
        return _store(self._environment, [(name, content)], verbose=options.verbose)

    async def delete(self, name: str, parameter: str | None, *, verbose: bool) -> None:
        """Delete a parameter, or all parameters of a namespace."""
        refuse_ros2_only(parameter=parameter)
        full_name = param_name(name, self._environment)
        async with master_client(self._environment) as client:
            if full_name == "/":
                # The root always has a value: deleting it means emptying it.
                await client.set_param("/", {})
            else:
                try:
                    await client.delete_param(full_name)
                except UnknownNameError:
                    raise await not_set(client, full_name) from None
        if verbose:
            write_line(
                "deleted ENTIRE parameter server" if full_name == "/" else f"deleted parameter [{full_name}]"
            )

    async def dump(self, file: Path | None, namespace: str, /, *, verbose: bool) -> None:
        """Write parameters to a YAML file; without a file, or with -, to stdout."""
        from rostether.param_yaml import dump

        if verbose:
            write_line(f"dumping namespace [{namespace}] to file [{file}]")
        text = dump((await _fetch(self._environment, namespace))[1])
        if file is None or str(file) == "-":
            write_line(text.removesuffix("\n"))
        else:
            write_file(file, text)

    def load(self, file: Path, namespace: str, /, *, verbose: bool) -> Coroutine[Any, Any, None]:
        """Set the parameters of a YAML file (- is stdin), in a namespace if one is given."""
        from rostether.param_yaml import parse_documents

        values = list(parse_documents(read_text(file), namespace, str(file)))
        return _store(self._environment, values, verbose=verbose)


async def _fetch(environment: RosEnvironment, name: str) -> tuple[str, Any]:
    full_name = param_name(name, environment)
    async with master_client(environment) as client:
        try:
            return full_name, await client.get_param(full_name)
        except UnknownNameError:
            raise await not_set(client, full_name) from None


async def _store(environment: RosEnvironment, values: list[tuple[str, Any]], *, verbose: bool) -> None:
    from rostether.param_yaml import leaves

    settings: list[tuple[str, ParamValue]] = []
    for name, value in values:
        full_name = param_name(name, environment)
        if full_name == "/" and not isinstance(value, dict):
            raise ConfigError("/ can only be set to a mapping of names to values, such as {speed: 1}")
        # All are checked before the first is set: a file with an error sets nothing.
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
            warn(f"WARNING: {error}; it is set, but roscpp nodes reject such names")
            return


def param_name(name: str, environment: RosEnvironment) -> str:
    """Return the full name of a parameter.

    Keys of YAML files often break the rules of names, as `max-speed` does. Masters accept them, so they can
    be read and deleted.
    """
    try:
        return resolve(name, environment)
    except InvalidNameError:
        return canonical(name if is_global(name) else environment.namespace + SEPARATOR + name)


async def not_set(client: MasterClient, name: str) -> UnknownNameError:
    """Return the error for a parameter that is not set, with the most similar name of those that are set."""
    known = _with_namespaces(await client.param_names())
    hint = did_you_mean(name, known) or "`rostether param list` lists those that are set"
    return UnknownNameError(f"parameter {name} is not set; {hint}")


def _with_namespaces(names: list[str]) -> set[str]:
    found = set(names)
    for name in names:
        while name := name.rpartition(SEPARATOR)[0]:
            found.add(name)
    return found
