"""Raw messages for clients on a ROS 2 graph: CDR with ROS 2 definitions."""

from __future__ import annotations

from rostether.msgdef.interface import MessageType
from rostether.msgdef.registry import Registry
from rostether.msgdef.ros2.definitions import Ros2Definitions
from rostether.ros2.types.native_registry import NativeRegistry
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import Ros2Types


class CdrForm:
    """Converts the graph port's messages to ROS 2's form; `registry` is the gateway's source of types."""

    def __init__(self, registry: Registry) -> None:
        self._types = (
            NativeTypes(registry)
            if isinstance(registry, NativeRegistry)
            else Ros2Types(registry, Ros2Definitions.from_environment())
        )

    def to_cdr(self, message_type: MessageType, payload: bytes) -> bytes:
        """Return a payload in CDR. Raises SerializationError, UnknownTypeError, TypeMismatchError."""
        return self._types.message(message_type).converter.to_cdr(payload)

    def full_text(self, message_type: MessageType) -> str:
        """Return the definitions of a type and of its nested types.

        Raises UnknownTypeError, TypeMismatchError.
        """
        return self._types.full_text(message_type)
