"""Message classes whose arrays of numbers are numpy arrays: views of the payload, without a copy."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rostether.errors import ConfigError
from rostether.serde.values import Message, MessageClasses


class NumpyMessage(Message):
    """A message with numpy arrays; `==` compares whole arrays."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Message):
            return NotImplemented
        return self._type == other._type and self.to_dict() == Message.to_dict(other)

    __hash__ = None  # type: ignore[assignment]


class NumpyClasses(MessageClasses):
    """Message classes for one type store; arrays that are received are read-only.

    Raises ConfigError if numpy is not installed.
    """

    base = NumpyMessage

    def __init__(self) -> None:
        super().__init__()
        try:
            # Imported by name, because only the program depends on numpy.
            self.view: Callable[[bytes, str, int, int], Any] = import_module("numpy").frombuffer
        except ImportError:
            raise ConfigError("numpy=True needs numpy; run: pip install numpy") from None

    def for_other_types(self) -> MessageClasses:
        """Return classes with numpy arrays for another registry's types."""
        return NumpyClasses()
