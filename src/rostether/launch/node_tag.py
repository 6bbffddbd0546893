"""Reads <node> and <test>; a <test> sets its parameters, but is not started."""

from __future__ import annotations

from rostether.errors import LaunchError
from rostether.launch.parameter_tags import ParameterTags
from rostether.launch.plan import LaunchNode, Output, WorkingFolder
from rostether.launch.scope import Scope
from rostether.launch.tag_reader import TagReader
from rostether.launch.values import split_words
from rostether.mechanisms.anonymous import anonymous_name
from rostether.mechanisms.xml_tree import XmlElement
from rostether.names.graph_name import PRIVATE, SEPARATOR, canonical, is_legal_name

_NODE_ATTRIBUTES = (
    *("pkg", "type", "name", "args", "machine", "ns", "clear_params", "output", "cwd", "launch-prefix"),
    *("respawn", "respawn_delay", "required"),
)
_NOT_IN_TESTS = ("respawn", "respawn_delay", "output")
_TEST_ATTRIBUTES = (*_NODE_ATTRIBUTES, "test-name", "time-limit", "retry")


class NodeTags:
    """Reads both tags. All methods raise LaunchError, ConfigError."""

    def __init__(self, reader: TagReader, parameters: ParameterTags) -> None:
        self._reader = reader
        self._parameters = parameters

    def node(self, element: XmlElement, scope: Scope) -> LaunchNode:
        """Return the node, and set its parameters."""
        reader = self._reader
        reader.check_attributes(element, _NODE_ATTRIBUTES)
        package, node_type = (self._filled(element, scope, name) for name in ("pkg", "type"))
        name = reader.required(element, scope, "name")
        inside = self._inside(element, scope, name)
        args = reader.optional(element, scope, "args") or ""
        launch_prefix = reader.optional(element, scope, "launch-prefix") or ""
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
            respawn=reader.flag(element, scope, "respawn"),
            respawn_delay_s=reader.number(element, scope, "respawn_delay"),
            required=reader.flag(element, scope, "required"),
            output=self._output(element, scope),
            working_folder=self._working_folder(element, scope),
            launch_prefix=launch_prefix,
            file=element.file,
            line=element.line,
        )
        if node.respawn and node.required:
            raise LaunchError("respawn= and required= are mutually exclusive; keep one of them")
        return node

    def test(self, element: XmlElement, scope: Scope) -> None:
        """Set a test's parameters."""
        reader = self._reader
        reader.check_attributes(element, _TEST_ATTRIBUTES)
        for name in _NOT_IN_TESTS:
            if name in element.attributes:
                raise LaunchError(f"<test> has no attribute {name}=; remove it")
        test_name = reader.required(element, scope, "test-name")
        for name in ("time-limit", "retry"):
            reader.number(element, scope, name)
        if "time-limit" in element.attributes and reader.number(element, scope, "time-limit") <= 0:
            raise LaunchError("time-limit= must be a number of seconds above 0")
        for name in ("pkg", "type"):
            self._filled(element, scope, name)
        self._inside(element, scope, reader.optional(element, scope, "name") or test_name)

    def _inside(self, element: XmlElement, scope: Scope, name: str) -> Scope:
        """Read the children, and return a scope with the node's namespace, remaps and environment."""
        reader = self._reader
        if SEPARATOR in name:
            raise LaunchError(f"name={name!r} contains a namespace; give it with ns=")
        if not is_legal_name(name):
            reader.warn(element, f"name={name!r} is not a ROS name; many programs will refuse it")
        inside = reader.namespace(element, scope, name)
        own = inside.child(name)
        own_params = {}
        for child in element.children:
            tag = child.tag.lower()
            if tag not in ("remap", "param", "rosparam", "env"):
                reader.warn(child, f"<{child.tag}> has no meaning inside <{element.tag}>; it is ignored")
                continue
            with reader.at_element(child):
                if not reader.applies(child, own if tag in ("param", "rosparam") else scope):
                    continue
                match tag:
                    case "remap":
                        reader.remap(child, inside)
                    case "env":
                        reader.environment(child, inside)
                    case "param":
                        key, value = self._parameters.name_and_value(child, own)
                        own_params[key] = (child, value)
                    case "rosparam":
                        self._parameters.rosparam(child, own)
        params = [(key, (element, value)) for key, value in scope.private_params.items()]
        for key, (source, value) in [*params, *own_params.items()]:
            with reader.at_element(source):
                reader.set_parameter(source, own.namespace + key.removeprefix(PRIVATE), value)
        return inside

    def _filled(self, element: XmlElement, scope: Scope, name: str) -> str:
        text = self._reader.required(element, scope, name)
        if not text.strip():
            raise LaunchError(f"<{element.tag}> has an empty {name}=; give it a value")
        return text

    def _output(self, element: XmlElement, scope: Scope) -> Output:
        text = self._reader.optional(element, scope, "output")
        try:
            return Output.LOG if text is None else Output(text)
        except ValueError:
            raise LaunchError(f"output={text!r:.200} is unknown; known: screen and log") from None

    def _working_folder(self, element: XmlElement, scope: Scope) -> WorkingFolder:
        text = self._reader.optional(element, scope, "cwd")
        try:
            return WorkingFolder("ROS_HOME" if text in (None, "ros_home") else text)
        except ValueError:
            raise LaunchError(f"cwd={text!r:.200} is unknown; known: node and ROS_HOME") from None
