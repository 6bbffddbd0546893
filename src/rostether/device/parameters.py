"""Requests parameters from the host."""

from __future__ import annotations

import asyncio
from collections import defaultdict, deque
from typing import TypeAlias

from rostether.errors import RostetherError, TransportTimeoutError, UnknownNameError
from rostether.rosserial.events import ParameterReceived, ParameterTimedOut

DeviceParam: TypeAlias = int | float | str | list[int] | list[float] | list[str]


class ParameterRequests:
    """The pending requests; requests for the same name are answered in order."""

    def __init__(self) -> None:
        self._waiting: defaultdict[str, deque[asyncio.Future[DeviceParam]]] = defaultdict(deque)

    async def wait(self, name: str) -> DeviceParam:
        """Wait for one answer. Raises UnknownNameError, TransportTimeoutError."""
        answer: asyncio.Future[DeviceParam] = asyncio.get_running_loop().create_future()
        waiting = self._waiting[name]
        waiting.append(answer)
        try:
            return await answer
        finally:
            if answer in waiting:
                waiting.remove(answer)

    def answered(self, event: ParameterReceived) -> None:
        """Pass an answer to the oldest request for that name."""
        value = _value_of(event)
        if value is None:
            self._finish(event.name, UnknownNameError(f"no parameter {event.name}; set it on the ROS side"))
        else:
            self._finish(event.name, value)

    def timed_out(self, event: ParameterTimedOut) -> None:
        """End the oldest request without an answer."""
        self._finish(
            event.name,
            TransportTimeoutError(f"the host did not answer for parameter {event.name}; try again"),
        )

    def fail_all(self, reason: str) -> None:
        """End all requests, because the line was lost or closed."""
        for name in list(self._waiting):
            while self._waiting[name]:
                self._finish(name, TransportTimeoutError(f"parameter {name}: {reason}"))

    def _finish(self, name: str, outcome: DeviceParam | RostetherError) -> None:
        waiting = self._waiting[name]
        while waiting:
            answer = waiting.popleft()
            if not answer.done():
                if isinstance(outcome, RostetherError):
                    answer.set_exception(outcome)
                else:
                    answer.set_result(outcome)
                return


def _value_of(event: ParameterReceived) -> DeviceParam | None:
    """Return a single value, or the list of one kind; None when the parameter does not exist."""
    values = event.ints or event.floats or event.strings
    return values[0] if len(values) == 1 else list(values) if values else None  # type: ignore[return-value]
