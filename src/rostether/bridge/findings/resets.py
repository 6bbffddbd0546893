"""A board that restarts repeatedly."""

from __future__ import annotations

from collections import deque

from rostether.bridge.findings.finding import Code, Finding, error

# Resets further apart than this may have different causes.
WINDOW_S = 60.0
# A user who presses the button may reset a board twice, and so may an upload.
MIN_RESETS = 3

# At 57600 baud fifty announcements and their confirmation take 2 s; this is four times that.
UNSETTLED_S = 8.0

# How many times a board may begin to answer: a healthy one does three or four times.
MIN_STARTS = 8


class Resets:
    """The resets of one board, over all its connections."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=1000)
        self._gone_s = float("-inf")

    def record(self, now_s: float, *, was_gone: bool = False) -> None:
        """Record a reset. `was_gone`: the port disappeared, so the board may have been unplugged."""
        self._times.append(now_s)
        if was_gone:
            self._gone_s = now_s

    def count(self, now_s: float) -> int:
        """Return the number of resets in the last minute."""
        while self._times and now_s - self._times[0] > WINDOW_S:
            self._times.popleft()
        return len(self._times)

    def find(self, now_s: float, crash_line: str | None) -> Finding | None:
        """Return the finding, if any; `crash_line` is the board's explanation."""
        count = self.count(now_s)
        if count < MIN_RESETS:
            return None
        first_s = self._times[0]
        what, plug = "reset", ""
        if self._gone_s >= first_s:
            what, plug = "reset or unplugged", "check the plug and the cable, "
        return reset_loop(f"the board was {what} {count} times in {now_s - first_s:.0f} s", crash_line, plug)


def reset_loop(seen: str, crash_line: str | None, first_step: str = "") -> Finding:
    """Return the finding, with the board's own explanation if there is one."""
    printed = f", and printed {crash_line!r}" if crash_line else ""
    return error(
        Code.RESET_LOOP,
        f"{seen}{printed}",
        f"{first_step}power motors and servos from a separate supply (a brown-out resets the board), check "
        "for a watchdog, and use smaller buffers and fewer topics in the sketch (the stack may overwrite "
        "the RAM)",
    )
