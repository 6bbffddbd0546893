"""A device's parameter requests. Answers have no name, so only one request is on the wire."""

from __future__ import annotations

from collections import deque

from rostether.errors import LocalProtocolError
from rostether.rosserial.packets import ParameterRequest

# Requests waiting for their turn; a sketch makes one at a time.
MAX_REQUESTS = 16


class ParameterQueue:
    """Requests in order; the first is on the wire."""

    def __init__(self) -> None:
        self._requests: deque[tuple[str, float]] = deque()
        self._due_s: float | None = None

    def add(self, name: str, timeout_s: float, now_s: float) -> str | None:
        """Queue a request; return the name to send now, None if it must wait its turn.

        Raises LocalProtocolError for a name that cannot be requested, or when too many requests wait.
        """
        if ParameterRequest.decode(ParameterRequest(name).encode()) is None:
            raise LocalProtocolError(f"{name!r} is not a parameter name; use at most 255 printable bytes")
        if len(self._requests) >= MAX_REQUESTS:
            raise LocalProtocolError("too many parameter requests are waiting; wait for an answer first")
        self._requests.append((name, timeout_s))
        return self.next_to_send(now_s) if len(self._requests) == 1 else None

    def next_to_send(self, now_s: float) -> str | None:
        """Return the name to send next, after the last request has ended; None if no request waits."""
        self._due_s = None
        if not self._requests:
            return None
        name, timeout_s = self._requests[0]
        self._due_s = now_s + timeout_s
        return name

    def pop_answered(self) -> str | None:
        """Remove the answered request; return its name, None if there was no request."""
        return self._requests.popleft()[0] if self._requests else None

    def pop_timed_out(self, now_s: float) -> str | None:
        """Remove the request that was not answered in time; return its name, None if there is none."""
        if self._due_s is None or now_s < self._due_s:
            return None
        return self._requests.popleft()[0]

    def get_timer(self) -> float | None:
        """Return when to call `pop_timed_out`, None if no request is on the wire."""
        return self._due_s
