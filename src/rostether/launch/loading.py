"""Reads launch files into a plan: the tags in their order, like roslaunch.

A later parameter with the same name replaces an earlier one. Settings in a <group>, <node> or <include> apply
only inside it; an included file gets only the arguments in its <include>.
"""

from __future__ import annotations

import getpass
import socket
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from rostether.errors import LaunchError
from rostether.launch.files import parse_launch_xml, read_file
from rostether.launch.node_tag import NodeTags
from rostether.launch.parameter_tags import ParameterTags
from rostether.launch.plan import DeclaredArgument, LaunchPlan
from rostether.launch.scope import Scope
from rostether.launch.substitution import LaunchContext
from rostether.launch.tag_reader import TagReader
from rostether.mechanisms.loopback import is_loopback
from rostether.mechanisms.xml_tree import XmlElement
from rostether.names.graph_name import as_namespace

_MACHINE_ATTRIBUTES = ("name", "address", "env-loader", "ssh-port", "user", "password", "default", "timeout")

# Some files include themselves to count down; the limit ends an endless recursion.
MAX_INCLUDE_DEPTH = 50

# The depth alone is not enough: 50 levels with two includes each are 2^50 files.
MAX_INCLUDES = 10_000
STDIN_NAME = "<stdin>"


def load_launch(
    paths: Iterable[Path | str],
    arguments: Mapping[str, str],
    environ: Mapping[str, str],
    packages: Mapping[str, Path],
    *,
    text: bytes | None = None,
    programs: Mapping[tuple[str, str], Sequence[str]] | None = None,
    builtin_packages: Iterable[str] = (),
    runs_commands: bool = True,
) -> LaunchPlan:
    """Read launch files in order into one plan.

    `arguments` are those of the command line. `packages` maps package names to folders. `text` is a launch
    file from standard input, which is read last. `programs` maps (package, program) to built-in command
    lines, for names such as `$(find xacro)/xacro` if the package is not installed. $(find) also finds the
    packages of `programs` and `builtin_packages`. Without `runs_commands`, nothing is executed, and
    parameters with `command=` are empty strings. Raises LaunchError with file and line.
    """
    programs = programs or {}
    built_in = frozenset(builtin_packages) | {package for package, _ in programs}
    context = LaunchContext(environ, packages, built_in)
    loader = _Loader(TagReader(context), programs, runs_commands=runs_commands)
    namespace = as_namespace(arguments.get("__ns") or environ.get("ROS_NAMESPACE") or "/")
    for path in paths:
        loader.load_root(read_file(str(path)), str(path), namespace, arguments)
    if text is not None:
        loader.load_root(text, STDIN_NAME, namespace, arguments)
    return loader.reader.plan


class _Loader:
    def __init__(
        self, reader: TagReader, programs: Mapping[tuple[str, str], Sequence[str]], *, runs_commands: bool
    ) -> None:
        self.reader = reader
        self._parameters = ParameterTags(reader, programs, runs_commands=runs_commands)
        self._nodes = NodeTags(reader, self._parameters)
        self._node_names: dict[str, XmlElement] = {}
        self._machines: set[str] = set()
        self._depth = 0
        self._includes = 0

    def load_root(self, data: bytes, file: str, namespace: str, arguments: Mapping[str, str]) -> None:
        root = self._parse(data, file)
        scope = Scope(file=file, namespace=namespace, arguments=dict(arguments))
        self._read_children(root, scope)
        for name, argument in scope.declared.items():
            self.reader.plan.arguments.setdefault(name, argument)

    def _parse(self, data: bytes, file: str) -> XmlElement:
        root = parse_launch_xml(data, file=file)
        if file not in self.reader.plan.files:
            self.reader.plan.files.append(file)
        if notice := root.attributes.get("deprecated"):
            self.reader.warn(root, f"deprecated: {notice}")
        return root

    def _read_children(self, parent: XmlElement, scope: Scope) -> None:
        for element in parent.children:
            with self.reader.at_element(element):
                if element.tag == "launch":
                    raise LaunchError("<launch> is inside <launch>; use <group> or <include>")
                if self.reader.applies(element, scope):
                    self._read(element, scope)

    def _read(self, element: XmlElement, scope: Scope) -> None:
        match element.tag:
            case "arg":
                self._arg(element, scope)
            case "group":
                self.reader.check_attributes(element, ("ns", "clear_params"))
                self._read_children(element, self.reader.namespace(element, scope))
            case "include":
                self._include(element, scope)
            case "node":
                self._node(element, scope)
            case "test":
                self._nodes.test(element, scope)
            case "param":
                self._parameters.param(element, scope)
            case "rosparam":
                self._parameters.rosparam(element, scope)
            case "remap":
                self.reader.remap(element, scope)
            case "env":
                self.reader.environment(element, scope)
            case "machine":
                self._machines.add(_read_machine(self.reader, element, scope))
            case "master":
                self.reader.warn(element, "<master> is obsolete; it is ignored")
            case _:
                self.reader.warn(element, f"<{element.tag}> is not a known tag; it is ignored")

    def _arg(self, element: XmlElement, scope: Scope, values: Scope | None = None) -> None:
        reader, values = self.reader, values or scope
        reader.check_attributes(element, ("name", "value", "default", "doc"))
        name = reader.required(element, values, "name")
        reader.plan.argument_names.add(name)
        value, default, doc = (reader.optional(element, values, each) for each in ("value", "default", "doc"))
        if value is not None and default is not None:
            raise LaunchError(f"argument {name!r} has both value= and default=; keep one of them")
        scope.declare(DeclaredArgument(name, default, doc or "", is_fixed=value is not None), value)

    def _node(self, element: XmlElement, scope: Scope) -> None:
        node = self._nodes.node(element, scope)
        machine = self.reader.optional(element, scope, "machine")
        if machine and machine not in self._machines:
            raise LaunchError(f"there is no <machine name={machine!r}> above; remove machine=")
        earlier = self._node_names.setdefault(node.full_name, element)
        if earlier is not element:
            raise LaunchError(
                f"two nodes have the name {node.full_name}, one at {earlier.file}:{earlier.line}; rename one"
            )
        self.reader.plan.nodes.append(node)

    def _include(self, element: XmlElement, scope: Scope) -> None:
        reader = self.reader
        reader.check_attributes(element, ("file", "ns", "clear_params", "pass_all_args"))
        file = reader.required(element, scope, "file")
        inside = reader.namespace(element, scope)
        pass_all = reader.flag(element, scope, "pass_all_args")
        given = Scope(
            file=file, arguments=dict(scope.arguments) if pass_all else {}, passes_all_arguments=pass_all
        )
        for child in element.children:
            with reader.at_element(child):
                if not reader.applies(child, inside):
                    continue
                match child.tag.lower():
                    case "arg":
                        self._arg(child, given, inside)
                    case "env":
                        reader.environment(child, inside)
                    case _:
                        reader.warn(child, f"<{child.tag}> has no meaning inside <include>; it is ignored")
        for name in given.declared:
            if name not in given.arguments:
                raise LaunchError(f"argument {name!r} needs value= or default= inside <include>")
        included = scope.included(file, inside, given.arguments, pass_all=pass_all)
        passed = list(included.arguments)
        self._read_included(element, included)
        unused = [name for name in passed if name not in included.declared]
        if unused and not pass_all:
            raise LaunchError(
                f"{file} declares no argument {' and no '.join(unused)}; remove it from <include>"
            )

    def _read_included(self, element: XmlElement, scope: Scope) -> None:
        self._includes += 1
        if self._depth >= MAX_INCLUDE_DEPTH:
            raise LaunchError(
                f"{scope.file} is included more than {MAX_INCLUDE_DEPTH} levels deep; if it includes itself, "
                "end the recursion with if= or unless="
            )
        if self._includes > MAX_INCLUDES:
            raise LaunchError(
                f"the launch files have more than {MAX_INCLUDES} includes; if one includes itself, end the "
                "recursion with if= or unless="
            )
        self._depth += 1
        try:
            self._read_children(self._parse(read_file(scope.file), scope.file), scope)
        except LaunchError as error:
            if " (included " in str(error) or not error.file:
                raise
            text = str(error).removeprefix(f"{error.file}:{error.line}: ")
            location = f"{element.file}:{element.line}"
            raise LaunchError(f"{text} (included at {location})", file=error.file, line=error.line) from None
        finally:
            self._depth -= 1


def _read_machine(reader: TagReader, element: XmlElement, scope: Scope) -> str:
    """Return the name of a <machine>. Raises LaunchError for another machine than this one."""
    reader.check_attributes(element, _MACHINE_ATTRIBUTES)
    name, address = (reader.required(element, scope, each) for each in ("name", "address"))
    user = reader.optional(element, scope, "user")
    is_here = address == socket.gethostname() or is_loopback(address)
    if not is_here or (user and user != getpass.getuser()):
        raise LaunchError(
            f"machine {name!r} at {address} is another machine, but nodes are started only on this machine; "
            "remove <machine>, and run `rostether launch` there with the ROS_MASTER_URI of this machine"
        )
    return name
