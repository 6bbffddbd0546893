"""The parameters of this program's node, which rclpy stores and offers through services."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rostether.errors import GraphError
from rostether.ros2.parameters.store import MAX_ASKED_NAMES, MAX_NAME_CHARACTERS, Changes, OwnParameters
from rostether.ros2.parameters.typed_value import NOT_SET, ParameterType, TypedValue
from rostether.ros2.rclpy.failures import attempt, first_lines
from rostether.ros2.rclpy.installation import interface_class, load_rclpy
from rostether.ros2.rclpy.own_node import OwnNode


class RclpyParameters(OwnParameters):
    """The parameters of a node of rclpy."""

    def __init__(self, own: OwnNode) -> None:
        super().__init__()
        self._own = own
        self._node = own.node
        self._asked: set[str] = set()
        add = getattr(self._node, "add_post_set_parameters_callback", None)
        if add is not None:
            add(self._note)
        else:
            # Humble calls back only before it sets the value; the event loop reports the change afterwards.
            self._node.add_on_set_parameters_callback(self._note_and_agree)

    def get(self, name: str) -> TypedValue:
        """Return a value, or `NOT_SET`."""
        if not self._node.has_parameter(name):
            return NOT_SET
        return _typed(self._node.get_parameter(name))

    def names(self) -> list[str]:
        """Return the names of all parameters that are set, sorted."""
        names = self._node.list_parameters([], 0).names
        return sorted(name for name in names if self.get(name) != NOT_SET)

    def declare(self, name: str) -> None:
        """Declare a requested parameter that is not set, so that `ros2 param list` shows it.

        Raises InvalidNameError, GraphError.
        """
        is_known = name in self._asked or self._node.has_parameter(name)
        if not name or len(name) > MAX_NAME_CHARACTERS or len(self._asked) >= MAX_ASKED_NAMES or is_known:
            return
        self._asked.add(name)
        descriptor = interface_class("rcl_interfaces/msg/ParameterDescriptor")(dynamic_typing=True)

        def declare() -> None:
            if not self._node.has_parameter(name):
                self._node.declare_parameter(name, None, descriptor)

        attempt(f"declare the parameter {name}", declare)

    def apply(self, values: Mapping[str, TypedValue]) -> None:
        """Set all the values, or none; `NOT_SET` deletes.

        Raises GraphError with the reason, InvalidNameError.
        """
        parameters = [_parameter(name, value) for name, value in values.items()]
        result = attempt("set parameters", lambda: self._node.set_parameters_atomically(parameters))
        if not result.successful:
            raise GraphError(
                f"cannot set parameters: {first_lines(result.reason) or 'rclpy gives no reason'}"
            )

    def _note(self, parameters: list[Any]) -> None:
        for parameter in parameters:
            self._describe(parameter)
        changes = Changes(changed={parameter.name: _typed(parameter) for parameter in parameters})
        self._own.thread.call_in_loop(self._report_changes, changes)

    def _describe(self, parameter: Any) -> None:
        """Describe a parameter that was set but not declared, because rclpy leaves its descriptor empty."""
        name, kind = parameter.name, parameter.type_.value
        if kind != ParameterType.NOT_SET and self._node.has_parameter(name):
            described = self._node.describe_parameter(name)
            if not described.name:
                described.name, described.type, described.dynamic_typing = name, kind, True
                self._node.set_descriptor(name, described)

    def _note_and_agree(self, parameters: list[Any]) -> Any:
        self._note(parameters)
        return interface_class("rcl_interfaces/msg/SetParametersResult")(successful=True)


def _typed(parameter: Any) -> TypedValue:
    kind = ParameterType(parameter.type_.value)
    value = parameter.value
    if kind is ParameterType.NOT_SET:
        return NOT_SET
    if kind is ParameterType.BYTE_ARRAY:
        return TypedValue(kind, b"".join(value))
    return TypedValue(kind, list(value) if kind > ParameterType.BYTE_ARRAY else value)


def _parameter(name: str, value: TypedValue) -> Any:
    parameter = load_rclpy().parameter.Parameter
    content: Any = value.value
    if isinstance(content, bytes):
        content = [bytes([byte]) for byte in content]
    return parameter(name, parameter.Type(int(value.type)), content)
