"""`rostether interface`: ROS 2 definitions, in the words of `ros2 interface`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import LazyGroup, Verb, VerbEntry
from rostether.errors import UnknownTypeError

if TYPE_CHECKING:
    from rostether.ros2.types.native_registry import NativeRegistry

_HERE = __name__


@click.group(
    cls=LazyGroup,
    verbs={
        "show": VerbEntry(f"{_HERE}:show", "Show the fields of a type."),
        "list": VerbEntry(f"{_HERE}:list_all", "List all types."),
        "package": VerbEntry(f"{_HERE}:package", "List the types of one package."),
        "packages": VerbEntry(f"{_HERE}:packages", "List the packages that have types."),
        "proto": VerbEntry(f"{_HERE}:proto", "Print a message to fill in, for topic pub."),
    },
    examples="rostether interface show sensor_msgs/msg/Imu",
)
def interface() -> None:
    """Show message and service definitions of ROS 2, like ros2 interface."""


_kind_options = (
    click.option("-m", "--only-msgs", is_flag=True, help="Only messages."),
    click.option("-s", "--only-srvs", is_flag=True, help="Only services."),
)


@click.command("show", cls=Verb, examples="rostether interface show std_srvs/srv/SetBool")
@click.argument("names", nargs=-1, required=True, metavar="TYPE...")
@msg_path_option
def show(names: tuple[str, ...], msg_paths: tuple[Path, ...]) -> None:
    """Show the fields of types, with all nested fields."""
    from rostether.cli.msg.ros2_definitions import shown

    registry = _registry(msg_paths)
    for name in names:
        write_line(shown(registry, _kind(name), name))


@click.command("list", cls=Verb, examples="rostether interface list --only-msgs")
@_kind_options[0]
@_kind_options[1]
@msg_path_option
def list_all(only_msgs: bool, only_srvs: bool, msg_paths: tuple[Path, ...]) -> None:
    """List all message and service types."""
    registry = _registry(msg_paths)
    for title, names in _chosen(registry, only_msgs=only_msgs, only_srvs=only_srvs):
        write_line(f"{title}:")
        for name in names:
            write_line(f"    {name}")


@click.command("package", cls=Verb, examples="rostether interface package std_msgs")
@click.argument("name", metavar="PACKAGE")
@msg_path_option
def package(name: str, msg_paths: tuple[Path, ...]) -> None:
    """List the types of one package."""
    registry = _registry(msg_paths)
    found = [*registry.messages(name), *registry.services(name)]
    if not found:
        raise UnknownTypeError(
            f"no package {name!r} with definitions is known; give its folder with --msg-path; "
            "`rostether interface packages` lists the known ones"
        )
    for each in found:
        write_line(each)


@click.command("packages", cls=Verb, examples="rostether interface packages")
@_kind_options[0]
@_kind_options[1]
@msg_path_option
def packages(only_msgs: bool, only_srvs: bool, msg_paths: tuple[Path, ...]) -> None:
    """List the packages that have message or service types."""
    registry = _registry(msg_paths)
    chosen = _chosen(registry, only_msgs=only_msgs, only_srvs=only_srvs)
    for name in sorted({each.partition("/")[0] for _, names in chosen for each in names}):
        write_line(name)


@click.command("proto", cls=Verb, examples="rostether interface proto geometry_msgs/msg/Twist")
@click.argument("name", metavar="TYPE")
@click.option("--no-quotes", is_flag=True, help="Without quotes around the text.")
@msg_path_option
def proto(name: str, no_quotes: bool, msg_paths: tuple[Path, ...]) -> None:
    """Print a message with its default values, or a service's request, as YAML."""
    from rostether.cli.topic.ros2_message_text import MessageText, TextStyle
    from rostether.cli.topic.ros2_typed_values import ValueForm
    from rostether.rostime import Time
    from rostether.serde.store import TypeStore

    registry = _registry(msg_paths)
    definition = registry.ros2_message(name) if _kind(name) == "msg" else registry.ros2_service(name).request
    form = ValueForm(registry.ros2_message, Time)
    message = form.fill(TypeStore(registry).codec(_short(definition.full_name)), definition, [])
    text = MessageText(registry.ros2_message, TextStyle(truncate_length=None)).yaml(message, definition)
    write_line(text.removesuffix("\n") if no_quotes else f'"{text}"')


def _registry(msg_paths: Sequence[Path]) -> NativeRegistry:
    from rostether.ros2.types.native_registry import NativeRegistry

    return NativeRegistry.from_environment(msg_paths)


def _kind(name: str) -> str:
    """Return `msg` or `srv`. Raises UsageError for a name that says neither."""
    parts = name.split("/")
    if len(parts) == 3 and parts[1] in ("msg", "srv"):
        return parts[1]
    if len(parts) == 3 and parts[1] == "action":
        raise click.UsageError(f"{name}: actions are not supported; their messages and services are")
    raise click.UsageError(f"{name!r} is not a type; write PACKAGE/msg/NAME or PACKAGE/srv/NAME")


def _short(name: str) -> str:
    from rostether.ros2.types.native_registry import short_name

    return short_name(name)


def _chosen(registry: NativeRegistry, *, only_msgs: bool, only_srvs: bool) -> list[tuple[str, list[str]]]:
    every = not (only_msgs or only_srvs)
    chosen = []
    if only_msgs or every:
        chosen.append(("Messages", registry.messages()))
    if only_srvs or every:
        chosen.append(("Services", registry.services()))
    return chosen
