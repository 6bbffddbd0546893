"""Reads <node> and <test>; a <test> sets its parameters, but is not started."""

from __future__ import annotations

from rostether.errors import LaunchError
from rostether.launch.parameter_tags import name_and_value, read_rosparam
from rostether.launch.plan import LaunchNode, Output, WorkingFolder
from rostether.launch.scope import Scope
from rostether.launch.tag import Tag, errors_at
from rostether.launch.values import split_words
from rostether.mechanisms.anonymous import anonymous_name
from rostether.names.graph_name import PRIVATE, SEPARATOR, canonical, is_legal_name

_NODE_ATTRIBUTES = (
    *("pkg", "type", "name", "args", "machine", "ns", "clear_params", "output", "cwd", "launch-prefix"),
    *("respawn", "respawn_delay", "required"),
)
_NOT_IN_TESTS = ("respawn", "respawn_delay", "output")
_TEST_ATTRIBUTES = (*_NODE_ATTRIBUTES, "test-name", "time-limit", "retry")


def read_node(tag: Tag) -> LaunchNode:
    """Return the node of a <node>, and set its parameters. Raises LaunchError, ConfigError."""
    tag.check_attributes(_NODE_ATTRIBUTES)
    package, node_type = (_filled(tag, name) for name in ("pkg", "type"))
    name = tag.required("name")
    inside = _inside(tag, name)
    args = tag.optional("args") or ""
    launch_prefix = tag.optional("launch-prefix") or ""
    for text in (args, launch_prefix):
        split_words(text)
    node = LaunchNode(
        package=package,
        type=node_type,
        # As in roslaunch, the private parameters of a node without a name are in its namespace.
        name=name or anonymous_name(node_type),
        namespace=canonical(inside.namespace),
        args=args,
        remaps=tuple(inside.remaps),
        environment=tuple(inside.environment),
        respawn=tag.flag("respawn"),
        respawn_delay_s=tag.number("respawn_delay"),
        required=tag.flag("required"),
        output=_output(tag.optional("output")),
        working_folder=_working_folder(tag.optional("cwd")),
        launch_prefix=launch_prefix,
        file=tag.element.file,
        line=tag.element.line,
    )
    if node.respawn and node.required:
        raise LaunchError("respawn= and required= are mutually exclusive; keep one of them")
    return node


def read_test(tag: Tag) -> None:
    """Set the parameters of a <test>. Raises LaunchError, ConfigError."""
    tag.check_attributes(_TEST_ATTRIBUTES)
    for name in _NOT_IN_TESTS:
        if name in tag.element.attributes:
            raise LaunchError(f"<test> has no attribute {name}=; remove it")
    test_name = tag.required("test-name")
    for name in ("time-limit", "retry"):
        tag.number(name)
    if "time-limit" in tag.element.attributes and tag.number("time-limit") <= 0:
        raise LaunchError("time-limit= must be a number of seconds above 0")
    for name in ("pkg", "type"):
        _filled(tag, name)
    _inside(tag, tag.optional("name") or test_name)


def _inside(tag: Tag, name: str) -> Scope:
    """Read the children, and return a scope with the node's namespace, remaps and environment."""
    if SEPARATOR in name:
        raise LaunchError(f"name={name!r} contains a namespace; give it with ns=")
    if not is_legal_name(name):
        tag.warn(f"name={name!r} is not a ROS name; many programs will refuse it")
    inside = tag.namespace(name)
    own = inside.child(name)
    own_params = {}
    for child in tag.element.children:
        kind = child.tag.lower()
        if kind not in ("remap", "param", "rosparam", "env"):
            text = f"<{child.tag}> has no meaning inside <{tag.element.tag}>; it is ignored"
            tag.at(child, own).warn(text)
            continue
        is_parameter = kind in ("param", "rosparam")
        with errors_at(child):
            if not tag.at(child, own if is_parameter else tag.scope).applies():
                continue
            inner = tag.at(child, own if is_parameter else inside)
            match kind:
                case "remap":
                    inner.remap()
                case "env":
                    inner.environment()
                case "param":
                    key, value = name_and_value(inner)
                    own_params[key] = (inner, value)
                case "rosparam":
                    read_rosparam(inner)
    params = [(key, (tag, value)) for key, value in tag.scope.private_params.items()]
    for key, (source, value) in [*params, *own_params.items()]:
        with errors_at(source.element):
            source.set_parameter(own.namespace + key.removeprefix(PRIVATE), value)
    return inside


def _filled(tag: Tag, name: str) -> str:
    text = tag.required(name)
    if not text.strip():
        raise LaunchError(f"<{tag.element.tag}> has an empty {name}=; give it a value")
    return text


def _output(text: str | None) -> Output:
    try:
        return Output.LOG if text is None else Output(text)
    except ValueError:
        raise LaunchError(f"output={text!r:.200} is unknown; known: screen and log") from None


def _working_folder(text: str | None) -> WorkingFolder:
    try:
        return WorkingFolder("ROS_HOME" if text in (None, "ros_home") else text)
    except ValueError:
        raise LaunchError(f"cwd={text!r:.200} is unknown; known: node and ROS_HOME") from None
