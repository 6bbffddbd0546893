"""Estimates the unread bytes in the UART of a board whose sketch sleeps in loop().

The established library answers one topic request in each spinOnce and leaves the bytes after it in the UART:
63 bytes on an AVR. While requests are unanswered, the host sends only what has room there. Requests can also
be lost, for example in a bootloader. So a request counts as unread until

    it is answered
    a time request comes without announcements  the established library sends it when it has read all bytes
    too much time has passed                    more than between two answers, or than any sketch sleeps
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

# The receive buffer of an AVR's UART in Arduino's core.
UART_BYTES = 63

# Topic requests are repeated less often if more is unread: the first message also needs room.
MANY_BYTES = 32

# The announcements of an answer follow its time request immediately.
OPENING_S = 0.25

# No sketch sleeps longer: a board that is silent for 4 s counts as gone.
LONGEST_LOOP_S = 5.0

# The loops of one board differ in length: the longest may take this many times the longest one so far.
LOOP_MARGIN = 1.5

# A sketch with shorter loops reads faster than requests are sent.
SHORT_LOOP_S = 0.2

# Publishers of our library announce this size. The library introduces itself without a request, reads all
# bytes, and answers all requests at once.
STREAMED_BYTES = 0xFFFF

_OTHER = 0
_TIME = -1

# The frame of a time answer.
TIME_ANSWER_BYTES = 16

# The frame of a topic request.
REQUEST_BYTES = 8

# A request waits for those before it, which fit in the UART.
MAX_LOOPS = UART_BYTES // REQUEST_BYTES + 1


class _Frame(NamedTuple):
    kind: int  # the protocol version of a request, or another kind
    size_bytes: int
    sent_s: float


class UnreadBytes:
    """The unread bytes of one board, from the frames that are sent, its answers, and their times."""

    def __init__(self) -> None:
        # How many bytes of messages may be sent now; None: any number.
        self.room_bytes: int | None = None
        self.version: int | None = None
        # The frames sent since the oldest unanswered request.
        self._frames: deque[_Frame] = deque()
        self._opened_s: float | None = None
        self.forget()

    def forget(self) -> None:
        """Forget the board: another one may be connected."""
        self.version = None
        self._reads_all = False
        self._answers = 0
        self._loop_s = 0.0
        self._answered_s = float("-inf")
        self._first_answer_s = 0.0
        self.read_all()

    @property
    def are_many(self) -> bool:
        """Whether another topic request would leave little room for the first message."""
        return self._unread_bytes > MANY_BYTES

    @property
    def has_room_for_time(self) -> bool:
        """Whether a time answer may be sent: at most one is unread, so that there is room for messages."""
        if self.room_bytes is None:
            return True
        is_waiting = any(frame.kind == _TIME for frame in self._frames)
        return self.room_bytes >= TIME_ANSWER_BYTES + REQUEST_BYTES and not is_waiting

    def requested(self, version: int, size_bytes: int, now_s: float) -> None:
        """Record a topic request that is sent."""
        if not self._reads_all:
            self._add(version, size_bytes, now_s)

    def sent(self, size_bytes: int, *, is_time: bool = False) -> None:
        """Record messages, or a time answer."""
        if self._frames and self._unread_bytes < UART_BYTES:
            self._add(_TIME if is_time else _OTHER, size_bytes, self._frames[-1].sent_s)

    def time_requested(self, now_s: float) -> None:
        """Handle a time request. The answer to a topic request begins with one; others come alone."""
        self._opened_s = now_s
        self._read_before = len(self._frames)

    def announced(self, buffer_size: int, now_s: float) -> None:
        """Handle an announcement; the first one after a time request shows that a request was read."""
        is_introduction = self._opened_s is None and self._answered_s == float("-inf")
        if is_introduction or buffer_size == STREAMED_BYTES:
            self.read_all(is_always=True)
        elif self._opened_s is not None:
            self._answered(now_s)
        self._opened_s = None
        self._answered_s = now_s

    def read_all(self, *, is_always: bool = False) -> None:
        """Record that nothing is unread; `is_always`: the board always reads all."""
        is_fast = self._answers > 1 and self._loop_s <= SHORT_LOOP_S
        self._reads_all = self._reads_all or is_always or is_fast
        self._frames.clear()
        self._unread_bytes = self._read_before = 0
        self._opened_s = None
        self._update()

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, None if nothing is scheduled."""
        if not self._frames or self.version is None:
            return None
        due_s = self._expiry_s(self._frames[0])
        return due_s if self._opened_s is None else min(due_s, self._opened_s + OPENING_S)

    def handle_timer(self, now_s: float) -> None:
        """Drop the requests that the board would have answered by now."""
        if self.version is None:
            return
        if self._opened_s is not None and now_s >= self._opened_s + OPENING_S:
            self._opened_s = None
            self._drop(self._read_before)
        if self._frames and now_s >= self._expiry_s(self._frames[0]):
            self._drop(sum(now_s >= self._expiry_s(frame) for frame in self._frames))

    def _answered(self, now_s: float) -> None:
        if not self._frames:
            return
        self._answers += 1
        if self._answers == 1:
            self._first_answer_s = now_s
        else:
            self._loop_s = max(self._loop_s, now_s - max(self._answered_s, self._frames[0].sent_s))
        kinds = [frame.kind for frame in self._frames]
        self._drop(kinds.index(self.version) + 1 if self.version in kinds else 0)

    def _expiry_s(self, frame: _Frame) -> float:
        if self._answers < 2:
            return max(self._answered_s, frame.sent_s) + LONGEST_LOOP_S
        wait_s = max(LOOP_MARGIN * self._loop_s, OPENING_S)
        return min(
            max(self._answered_s, frame.sent_s) + wait_s,
            max(self._first_answer_s, frame.sent_s) + MAX_LOOPS * wait_s,
        )

    def _drop(self, count: int) -> None:
        for _ in range(count):
            self._unread_bytes -= self._frames.popleft().size_bytes
        self._read_before = max(self._read_before - count, 0)
        if all(frame.kind != self.version for frame in self._frames):
            self.read_all()
        self._update()

    def _add(self, kind: int, size_bytes: int, now_s: float) -> None:
        room_bytes = UART_BYTES - self._unread_bytes
        if self.version is None and size_bytes > room_bytes:
            # A full UART keeps the first bytes and loses the rest.
            kind, size_bytes = _OTHER, room_bytes
        if size_bytes:
            self._frames.append(_Frame(kind, size_bytes, now_s))
            self._unread_bytes += size_bytes
            self._update()

    def _update(self) -> None:
        self.room_bytes = UART_BYTES - self._unread_bytes if self._frames else None
