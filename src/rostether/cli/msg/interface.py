"""`rostether interface`: ROS 2 definitions, with the subcommands of `ros2 interface`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rostether.cli.access.options import msg_path_option
from rostether.cli.msg.group import check_package
from rostether.cli.shell.option_group import add_flag, option_group
from rostether.cli.shell.output import write_line
from rostether.cli.shell.verbs import verb, verb_group

if TYPE_CHECKING:
    from rostether.ros2.types.native_registry import NativeRegistry


interface = verb_group(
    "interface",
    "Show message, service and action definitions of ROS 2, like ros2 interface.",
    {
        "show": ("interface:show", "Show the fields of a type."),
        "list": ("interface:list_all", "List all types."),
        "package": ("interface:package", "List the types of one package."),
        "packages": ("interface:packages", "List the packages that have types."),
        "proto": ("interface:proto", "Print a message to fill in, for topic pub."),
    },
    "rostether interface show sensor_msgs/msg/Imu",
    package="rostether.cli.msg",
)

# The middle part of a type's name -> the title of a list.
_TITLES = {"msg": "Messages", "srv": "Services", "action": "Actions"}


def _chosen_kinds(
    *, only_msgs: bool = False, only_srvs: bool = False, only_actions: bool = False
) -> list[str]:
    chosen = zip(_TITLES, (only_msgs, only_srvs, only_actions), strict=True)
    return [kind for kind, is_chosen in chosen if is_chosen] or list(_TITLES)


# Options that choose kinds of types; the verb gets the chosen ones as `kinds`, or all.
_kind_options = option_group(
    "kinds",
    _chosen_kinds,
    (
        add_flag("-m --only-msgs", "Only messages."),
        add_flag("-s --only-srvs", "Only services."),
        add_flag("-a --only-actions", "Only actions."),
    ),
)


@verb("show", "rostether interface show std_srvs/srv/SetBool")
@click.argument("names", nargs=-1, required=True, metavar="TYPE...")
@add_flag("--all-comments", "Show the comments of nested types too.")
@add_flag("--no-comments", "Show no comments and no empty lines.")
@msg_path_option
def show(names: tuple[str, ...], all_comments: bool, no_comments: bool, msg_paths: tuple[Path, ...]) -> None:
    """Show definitions, with each field's type below the field; `-` reads a type from stdin.

    The bundled definitions have no comments.
    """
    from rostether.cli.msg.ros2_definitions import Comments, shown

    if all_comments and no_comments:
        raise click.UsageError("--all-comments and --no-comments are mutually exclusive; give one of them")
    comments = Comments.ALL if all_comments else Comments.NONE if no_comments else Comments.OWN
    registry = _registry(msg_paths)
    for given in names:
        name = sys.stdin.readline().strip() if given == "-" else given
        write_line(shown(registry, _kind(name), name, comments))


@verb("list", "rostether interface list --only-msgs")
@_kind_options
@msg_path_option
def list_all(kinds: list[str], msg_paths: tuple[Path, ...]) -> None:
    """List all message, service and action types."""
    registry = _registry(msg_paths)
    for kind in kinds:
        write_line(f"{_TITLES[kind]}:")
        for name in _names(registry, kind):
            write_line(f"    {name}")


@verb("package", "rostether interface package std_msgs")
@click.argument("name", metavar="PACKAGE")
@_kind_options
@msg_path_option
def package(name: str, kinds: list[str], msg_paths: tuple[Path, ...]) -> None:
    """List the types of one package."""
    registry = _registry(msg_paths)
    found = [each for kind in kinds for each in _names(registry, kind, name)]
    check_package(name, registry, "interface packages")
    for each in found:
        write_line(each)


@verb("packages", "rostether interface packages")
@_kind_options
@msg_path_option
def packages(kinds: list[str], msg_paths: tuple[Path, ...]) -> None:
    """List the packages that have message, service or action types."""
    registry = _registry(msg_paths)
    names = [each for kind in kinds for each in _names(registry, kind)]
    for name in sorted({each.partition("/")[0] for each in names}):
        write_line(name)


@verb("proto", "rostether interface proto geometry_msgs/msg/Twist")
@click.argument("name", metavar="TYPE")
@add_flag("--no-quotes", "Print the text without quotes.")
@msg_path_option
def proto(name: str, no_quotes: bool, msg_paths: tuple[Path, ...]) -> None:
    """Print a message with its default values, a service's request, or an action's goal, as YAML."""
    from rostether.ros2.types.message_text import MessageText, TextStyle
    from rostether.ros2.types.native_registry import short_name
    from rostether.ros2.types.native_types import NativeClasses
    from rostether.serde.store import TypeStore

    registry = _registry(msg_paths)
    match _kind(name):
        case "msg":
            definition = registry.ros2_message(name)
        case "srv":
            definition = registry.ros2_service(name).request
        case _:
            definition = registry.definitions.action(name).action.goal
    store = TypeStore(registry, NativeClasses(registry))
    message = store.codec(short_name(definition.full_name)).message_class()
    text = MessageText(registry.ros2_message, TextStyle(truncate_length=None)).yaml(message, definition)
    write_line(text.removesuffix("\n") if no_quotes else f'"{text}"')


def _registry(msg_paths: Sequence[Path]) -> NativeRegistry:
    from rostether.ros2.types.native_registry import NativeRegistry

    return NativeRegistry.from_environment(msg_paths)


def _kind(name: str) -> str:
    """Return `msg`, `srv` or `action`. Raises UsageError for a name without one of them."""
    parts = name.split("/")
    if len(parts) == 3 and parts[1] in _TITLES:
        return parts[1]
    raise click.UsageError(
        f"{name!r} is not a type; write PACKAGE/msg/NAME, PACKAGE/srv/NAME or PACKAGE/action/NAME"
    )


def _names(registry: NativeRegistry, kind: str, package: str | None = None) -> list[str]:
    from rostether.msgdef.definition_files import Kind

    return registry.definitions.names(Kind(kind), package)
