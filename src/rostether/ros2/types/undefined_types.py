"""Types for tools that only count and measure messages: a type without a definition stays CDR."""

from __future__ import annotations

from typing import cast

from rostether.errors import UnknownTypeError
from rostether.msgdef.interface import ANY_MESSAGE
from rostether.ros2.types.native_types import NativeTypes
from rostether.ros2.types.type_support import ANY_HASH, MessageSupport
from rostether.serde.cdr.converter import CdrConverter


class UndefinedTypes(NativeTypes):
    """Types by name, known or not."""

    def by_name(self, name: str) -> MessageSupport:
        """Return a ROS 2 message; one without a definition is handed on as CDR. Raises DefinitionError."""
        try:
            return super().by_name(name)
        except UnknownTypeError:
            return MessageSupport(name, ANY_HASH, ANY_MESSAGE, cast("CdrConverter", _Unchanged()))


class _Unchanged:
    """Hands CDR on as it is."""

    def from_cdr(self, cdr: bytes) -> bytes:
        """Return the CDR."""
        return cdr
