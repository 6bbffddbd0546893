"""`rostether msg` and `rostether srv`: message and service definitions, in rosmsg's form."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec import Struct

from rostether.cli.access.completions import complete_message_types, complete_service_types
from rostether.cli.access.graph_options import GraphOptions, graph_options
from rostether.cli.access.options import msg_path_option
from rostether.cli.msg.recorded_types import bag_option, recorded_registry
from rostether.cli.shell.option_group import add_flag
from rostether.cli.shell.output import json_option, write_json, write_line
from rostether.cli.shell.verbs import verb, verb_group
from rostether.errors import UnknownTypeError
from rostether.mechanisms.text import did_you_mean

if TYPE_CHECKING:
    from rostether.msgdef.registry import Registry
    from rostether.msgdef.spec import MessageSpec


class _Kind(Struct, frozen=True):
    """The differences between the two groups."""

    group: str
    what: str
    example: str
    type_command: str
    complete: Callable[..., list[str]]

    def names(self, registry: Registry, package: str | None = None) -> list[str]:
        return registry.messages(package) if self.group == "msg" else registry.services(package)

    def parts(self, registry: Registry, name: str) -> tuple[str, list[MessageSpec]]:
        """Return the source text, and the message, or the request and the response."""
        if self.group == "msg":
            message = registry.message(name)
            return message.text, [message]
        service = registry.service(name)
        return service.text, [service.request, service.response]

    def md5sum(self, registry: Registry, name: str, *, is_ros2: bool) -> str:
        """Return the md5sum, or the type hash of ROS 2."""
        if is_ros2:
            from rostether.cli.msg.ros2_definitions import type_hash

            return type_hash(registry, self.group, name)
        if self.group == "msg":
            return registry.message_type(name).md5sum
        return registry.service_type(name).md5sum


_MESSAGES = _Kind(
    "msg", "message", "sensor_msgs/Range", "rostether topic type /ultrasound", complete_message_types
)
_SERVICES = _Kind(
    "srv", "service", "std_srvs/SetBool", "rostether service type /set_led", complete_service_types
)


def _group(kind: _Kind) -> click.Command:
    group, what = kind.group, kind.what
    text = f"Show {what} definitions: built-in ones, and those of your packages."
    verbs = {
        "show": (f"group:{group}_show", f"Show the fields of a {what} type."),
        "info": (f"group:{group}_show", "The same as show."),
        "list": (f"group:{group}_list", f"List all {what} types."),
        "md5": (f"group:{group}_md5", f"Print the md5sum of a {what} type."),
        "package": (f"group:{group}_package", f"List the {what} types of one package."),
        "packages": (f"group:{group}_packages", f"List the packages that have {what} types."),
    }
    example = f"rostether {group} show {kind.example}"
    return verb_group(group, text, verbs, example, package="rostether.cli.msg")


def _registry(msg_paths: tuple[Path, ...], graph: GraphOptions) -> Registry:
    if graph.ros2 is not None:
        from rostether.ros2.types.native_registry import NativeRegistry

        return NativeRegistry.from_environment(msg_paths)
    from rostether.msgdef.registry import Registry

    return Registry.from_environment(msg_paths)


def format_spec(registry: Registry, spec: MessageSpec, indent: str = "") -> Iterator[str]:
    """Yield a message's lines: constants, then fields; those of nested messages are indented.

    Raises UnknownTypeError and DefinitionError for a nested message.
    """
    from rostether.msgdef.primitives import PRIMITIVE_TYPES

    for constant in spec.constants:
        yield f"{indent}{constant.type} {constant.name}={constant.text}"
    for field in spec.fields:
        yield f"{indent}{field.type} {field.name}"
        if field.type.base not in PRIMITIVE_TYPES:
            yield from format_spec(registry, registry.message(field.type.base), indent + "  ")


def _record(kind: _Kind, registry: Registry, name: str) -> dict[str, Any]:
    def describe(spec: MessageSpec) -> dict[str, Any]:
        return {
            "constants": [{"type": c.type, "name": c.name, "value": c.value} for c in spec.constants],
            "fields": [{"type": str(field.type), "name": field.name} for field in spec.fields],
        }

    parts = kind.parts(registry, name)[1]
    described = dict(zip(("request", "response"), map(describe, parts), strict=False))
    body = describe(parts[0]) if kind is _MESSAGES else described
    return {"type": name, "md5sum": kind.md5sum(registry, name, is_ros2=False), **body}


def _text(kind: _Kind, registry: Registry, name: str, *, raw: bool) -> str:
    from rostether.cli.msg.ros2_definitions import shown_definition

    text, parts = kind.parts(registry, name)
    if raw:
        return text
    return "---\n".join(
        shown_definition(part, registry.message, format_spec(registry, part)) for part in parts
    )


def _type_argument(kind: _Kind, given: str | None) -> str:
    """Return the type name: an argument, or a line of stdin (`rostether topic type /x | ...`)."""
    name = given
    while not name:
        if sys.stdin.isatty():
            raise click.UsageError(f"give a {kind.what} type, for example {kind.example}")
        line = sys.stdin.readline()
        if not line:
            raise click.UsageError(
                f"stdin contains no {kind.what} type; write one, for example {kind.example}"
            )
        name = line.strip()
    name = name.removesuffix(f".{kind.group}")
    if "::" in name or "." in name:
        raise click.UsageError(f"{name!r} is not a type name; write package/Name, e.g. {kind.example}")
    return name


def check_package(name: str, registry: Registry, list_command: str) -> None:
    """Raise UnknownTypeError for a package without definitions; `list_command` lists packages with some."""
    if name not in registry.packages():
        meant = did_you_mean(name, registry.packages(), then=" Otherwise, ")
        raise UnknownTypeError(
            f"no package {name!r} with definitions is known; {meant}give its folder with --msg-path; "
            f"`rostether {list_command}` lists the known ones"
        )


def _matches(kind: _Kind, registry: Registry, name: str) -> list[str]:
    """Return the full names that match a type name without its package."""
    names = kind.names(registry)
    found = [each for each in names if each.rpartition("/")[2] == name]
    if not found:
        short_names = {each.rpartition("/")[2] for each in names}
        hint = did_you_mean(name, short_names) or f"`rostether {kind.group} list` shows all"
        raise UnknownTypeError(f"no package has a {kind.what} {name!r}; {hint}")
    return found


def _show_verb(kind: _Kind) -> click.Command:
    package, _, name_alone = kind.example.partition("/")
    examples = f"""
    rostether {kind.group} show {kind.example}
    rostether {kind.group} show {name_alone}
    {kind.type_command} | rostether {kind.group} show
    rostether {kind.group} show --ros2 {package}/{kind.group}/{name_alone}
    """

    @verb("show", examples)
    @click.argument("name", required=False, metavar="TYPE", shell_complete=kind.complete)
    @bag_option(kind.group)
    @add_flag("-r --raw", "Show the original text of the definition.")
    @json_option
    @msg_path_option
    @graph_options(master=False)
    def show(
        name: str | None,
        raw: bool,
        as_json: bool,
        msg_paths: tuple[Path, ...],
        graph: GraphOptions,
        bag: Path | None = None,
    ) -> None:
        from rostether.cli.msg import ros2_definitions as ros2

        is_ros2 = graph.ros2 is not None and bag is None
        given = _type_argument(kind, name)
        registry = _registry(msg_paths, graph) if bag is None else recorded_registry(bag, given)
        is_short = "/" not in given
        for each in _matches(kind, registry, given) if is_short else [given]:
            if as_json:
                record = ros2.record(registry, kind.group, each) if is_ros2 else _record(kind, registry, each)
                write_json(record)
                continue
            if is_short:
                write_line(f"[{each}]:")
            if is_ros2:
                write_line(ros2.shown(registry, kind.group, each, raw=raw))
            else:
                write_line(_text(kind, registry, each, raw=raw))

    ros2_help = "with --ros2, those that it has in ROS 2."
    show.help = f"Show the fields of a {kind.what} type, with all nested fields; {ros2_help}"
    return show


def _md5_verb(kind: _Kind) -> click.Command:
    @verb("md5", f"rostether {kind.group} md5 {kind.example}")
    @click.argument("name", required=False, metavar="TYPE", shell_complete=kind.complete)
    @msg_path_option
    @graph_options(master=False)
    def md5(name: str | None, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
        registry = _registry(msg_paths, graph)
        given = _type_argument(kind, name)
        if "/" in given:
            write_line(kind.md5sum(registry, given, is_ros2=graph.ros2 is not None))
        else:
            for each in _matches(kind, registry, given):
                write_line(f"[{each}]: {kind.md5sum(registry, each, is_ros2=graph.ros2 is not None)}")

    md5.help = (
        f"Print the md5sum of a {kind.what} type, or with --ros2 its type hash; both ends of a connection "
        "need the same."
    )
    return md5


def _list_verb(kind: _Kind) -> click.Command:
    @verb("list", f"rostether {kind.group} list --msg-path ~/catkin_ws/src")
    @msg_path_option
    @graph_options(master=False)
    def list_all(msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
        for name in kind.names(_registry(msg_paths, graph)):
            write_line(name)

    list_all.help = f"List all {kind.what} types."
    return list_all


def _package_verb(kind: _Kind) -> click.Command:
    @verb("package", f"rostether {kind.group} package {kind.example.partition('/')[0]}")
    @click.argument("package")
    @add_flag("-s single_line", "Print the names on one line.")
    @msg_path_option
    @graph_options(master=False)
    def package_types(
        package: str, single_line: bool, msg_paths: tuple[Path, ...], graph: GraphOptions
    ) -> None:
        registry = _registry(msg_paths, graph)
        check_package(package, registry, f"{kind.group} packages")
        write_line((" " if single_line else "\n").join(kind.names(registry, package)))

    package_types.help = f"List the {kind.what} types of one package."
    return package_types


def _packages_verb(kind: _Kind) -> click.Command:
    @verb("packages", f"rostether {kind.group} packages -s")
    @add_flag("-s single_line", "Print the names on one line.")
    @msg_path_option
    @graph_options(master=False)
    def packages(single_line: bool, msg_paths: tuple[Path, ...], graph: GraphOptions) -> None:
        names = dict.fromkeys(name.partition("/")[0] for name in kind.names(_registry(msg_paths, graph)))
        write_line((" " if single_line else "\n").join(names))

    packages.help = f"List the packages that have {kind.what} types."
    return packages


msg, srv = _group(_MESSAGES), _group(_SERVICES)
msg_show, srv_show = _show_verb(_MESSAGES), _show_verb(_SERVICES)
msg_md5, srv_md5 = _md5_verb(_MESSAGES), _md5_verb(_SERVICES)
msg_list, srv_list = _list_verb(_MESSAGES), _list_verb(_SERVICES)
msg_package, srv_package = _package_verb(_MESSAGES), _package_verb(_SERVICES)
msg_packages, srv_packages = _packages_verb(_MESSAGES), _packages_verb(_SERVICES)
