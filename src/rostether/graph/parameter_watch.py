"""Watches of parameters: a callback gets the value, and each new one, but no value twice in a row."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from rostether.graph.callbacks import call_safely
from rostether.graph.ports import ParamValue


class NewValues:
    """Passes the values of a parameter to a callback, the first one and those that are new."""

    def __init__(self, name: str, on_change: Callable[[ParamValue], None]) -> None:
        self.name = name
        self._on_change = on_change
        # The last value; empty before the first one.
        self._latest: list[ParamValue] = []

    def report(self, value: ParamValue) -> None:
        """Call back if the value is new, or only its type, as in True after 1."""
        if not self._latest or value != self._latest[0] or type(value) is not type(self._latest[0]):
            self._latest = [value]
            call_safely(f"on_change of parameter {self.name}", self._on_change, value)


class ParameterWatch(NewValues):
    """Implements `graph.ports.Watch`; `on_close` is called once, with the watch."""

    def __init__(
        self, name: str, on_change: Callable[[ParamValue], None], on_close: Callable[[Any], Awaitable[None]]
    ) -> None:
        super().__init__(name, on_change)
        self.is_closed = False
        self._on_close = on_close

    def report(self, value: ParamValue) -> None:
        """Call back if the value is new, until the watch is closed."""
        if not self.is_closed:
            super().report(value)

    async def close(self) -> None:
        """Stop watching. Idempotent."""
        if not self.is_closed:
            self.is_closed = True
            await self._on_close(self)
