"""Reads launch files into a plan: the tags in their order, like roslaunch.

A later parameter with the same name replaces an earlier one. Settings in a <group>, <node> or <include> apply
only inside it; an included file gets only the arguments in its <include>.
"""

from __future__ import annotations

import getpass
import socket
from collections.abc import Iterable, Mapping
from pathlib import Path

from rostether.errors import LaunchError
from rostether.launch.files import parse_launch_xml, read_file
from rostether.launch.node_tag import read_node, read_test
from rostether.launch.parameter_tags import read_param, read_rosparam
from rostether.launch.plan import DeclaredArgument, LaunchPlan
from rostether.launch.scope import Scope
from rostether.launch.substitution import LaunchContext
from rostether.launch.tag import Reading, Tag, errors_at
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
    context: LaunchContext,
    *,
    text: bytes | None = None,
) -> LaunchPlan:
    """Read launch files in order into one plan.

    `arguments` are those of the command line. `text` is a launch file from standard input, which is read
    last. Raises LaunchError with file and line.
    """
    loader = _Loader(context)
    namespace = as_namespace(arguments.get("__ns") or context.environ.get("ROS_NAMESPACE") or "/")
    for path in paths:
        loader.load_root(read_file(str(path)), str(path), namespace, arguments)
    if text is not None:
        loader.load_root(text, STDIN_NAME, namespace, arguments)
    return loader.plan


class _Loader:
    def __init__(self, context: LaunchContext) -> None:
        self._reading = Reading(context)
        self.plan = self._reading.plan
        self._node_names: dict[str, XmlElement] = {}
        self._machines: set[str] = set()
        self._depth = 0
        self._includes = 0

    def load_root(self, data: bytes, file: str, namespace: str, arguments: Mapping[str, str]) -> None:
        root = parse_launch_xml(data, file=file)
        scope = Scope(file=file, namespace=namespace, arguments=dict(arguments))
        self._read_file(Tag(root, scope, self._reading))
        for name, argument in scope.declared.items():
            self.plan.arguments.setdefault(name, argument)

    def _read_file(self, root: Tag) -> None:
        if root.scope.file not in self.plan.files:
            self.plan.files.append(root.scope.file)
        if notice := root.element.attributes.get("deprecated"):
            root.warn(f"deprecated: {notice}")
        self._read_children(root, root.scope)

    def _read_children(self, parent: Tag, scope: Scope) -> None:
        for element in parent.element.children:
            with errors_at(element):
                if element.tag == "launch":
                    raise LaunchError("<launch> is inside <launch>; use <group> or <include>")
                tag = parent.at(element, scope)
                if tag.applies():
                    self._read(tag)

    def _read(self, tag: Tag) -> None:
        match tag.element.tag:
            case "arg":
                _read_arg(tag, tag.scope)
            case "group":
                tag.check_attributes(("ns", "clear_params"))
                self._read_children(tag, tag.namespace())
            case "include":
                self._include(tag)
            case "node":
                self._node(tag)
            case "test":
                read_test(tag)
            case "param":
                read_param(tag)
            case "rosparam":
                read_rosparam(tag)
            case "remap":
                tag.remap()
            case "env":
                tag.environment()
            case "machine":
                self._machines.add(_read_machine(tag))
            case "master":
                tag.warn("<master> is obsolete; it is ignored")
            case _:
                tag.warn(f"<{tag.element.tag}> is not a known tag; it is ignored")

    def _node(self, tag: Tag) -> None:
        node = read_node(tag)
        machine = tag.optional("machine")
        if machine and machine not in self._machines:
            raise LaunchError(f"there is no <machine name={machine!r}> above; remove machine=")
        earlier = self._node_names.setdefault(node.full_name, tag.element)
        if earlier is not tag.element:
            raise LaunchError(
                f"two nodes have the name {node.full_name}, one at {earlier.file}:{earlier.line}; rename one"
            )
        self.plan.nodes.append(node)

    def _include(self, tag: Tag) -> None:
        tag.check_attributes(("file", "ns", "clear_params", "pass_all_args"))
        file = tag.required("file")
        inside = tag.namespace()
        pass_all = tag.flag("pass_all_args")
        arguments = dict(tag.scope.arguments) if pass_all else {}
        given = Scope(file=file, arguments=arguments, passes_all_arguments=pass_all)
        for element in tag.element.children:
            child = tag.at(element, inside)
            with errors_at(element):
                if not child.applies():
                    continue
                match element.tag.lower():
                    case "arg":
                        _read_arg(child, given)
                    case "env":
                        child.environment()
                    case _:
                        child.warn(f"<{element.tag}> has no meaning inside <include>; it is ignored")
        for name in given.declared:
            if name not in given.arguments:
                raise LaunchError(f"argument {name!r} needs value= or default= inside <include>")
        included = tag.scope.included(file, inside, given.arguments, pass_all=pass_all)
        passed = list(included.arguments)
        self._read_included(tag, included)
        unused = [name for name in passed if name not in included.declared]
        if unused and not pass_all:
            raise LaunchError(
                f"{file} declares no argument {' and no '.join(unused)}; remove it from <include>"
            )

    def _read_included(self, tag: Tag, scope: Scope) -> None:
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
            root = parse_launch_xml(read_file(scope.file), file=scope.file)
            self._read_file(tag.at(root, scope))
        except LaunchError as error:
            if " (included " in str(error) or not error.file:
                raise
            text = str(error).removeprefix(f"{error.file}:{error.line}: ")
            location = f"{tag.element.file}:{tag.element.line}"
            raise LaunchError(f"{text} (included at {location})", file=error.file, line=error.line) from None
        finally:
            self._depth -= 1


def _read_arg(tag: Tag, declaring: Scope) -> None:
    """Declare the argument of an <arg> in a scope."""
    tag.check_attributes(("name", "value", "default", "doc"))
    name = tag.required("name")
    tag.reading.plan.argument_names.add(name)
    value, default, doc = map(tag.optional, ("value", "default", "doc"))
    if value is not None and default is not None:
        raise LaunchError(f"argument {name!r} has both value= and default=; keep one of them")
    declaring.declare(DeclaredArgument(name, default, doc or "", is_fixed=value is not None), value)


def _read_machine(tag: Tag) -> str:
    """Return the name of a <machine>. Raises LaunchError for another machine than this one."""
    tag.check_attributes(_MACHINE_ATTRIBUTES)
    name, address = map(tag.required, ("name", "address"))
    user = tag.optional("user")
    is_here = address == socket.gethostname() or is_loopback(address)
    if not is_here or (user and user != getpass.getuser()):
        raise LaunchError(
            f"machine {name!r} at {address} is another machine, but nodes are started only on this machine; "
            "remove <machine>, and run `rostether launch` there with the ROS_MASTER_URI of this machine"
        )
    return name
