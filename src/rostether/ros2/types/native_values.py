"""Messages of ROS 2 definitions as values: missing fields have the defaults of ROS 2."""

from __future__ import annotations

from typing import Any

from rostether.errors import DefinitionError
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.serde.type_tree import Array, Node, Struct
from rostether.serde.values import Message, MessageClasses


class NativeClasses(MessageClasses):
    """Message classes for a `NativeRegistry`'s store: a Quaternion's w is 1, as with rclpy."""

    are_shared = False

    def __init__(self, registry: NativeRegistry) -> None:
        super().__init__()
        self._registry = registry

    def _make(self, tree: Struct) -> type[Message]:
        message_class = super()._make(tree)
        defaults = self._defaults(tree)
        if defaults:
            message_class._zeros = tuple(
                (member.name, _maker(member.node, defaults[member.name]) if member.name in defaults else zero)
                for member, (_, zero) in zip(tree.members, message_class._zeros, strict=True)
            )
        return message_class

    def _defaults(self, tree: Struct) -> dict[str, Any]:
        try:
            definition = self._registry.ros2_message(tree.name)
        except DefinitionError:
            # A peer's own definition in ROS 1's form has no defaults.
            return {}
        return {field.name: field.default for field in definition.fields if field.default is not None}


def _maker(node: Node, default: Any) -> Any:
    """Return an immutable value, or a function that makes a mutable one."""
    if not isinstance(node, Array):
        return default
    values = tuple(default)
    return bytes(values) if node.is_bytes else lambda: list(values)
