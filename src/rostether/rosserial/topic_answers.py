"""Tracks the topic requests that wait for an answer, and interprets the board's time requests.

    an answer            time request, then the announcements
    an introduction      known announcements, then a time request: a board with our library has restarted
    neither              only a time request: it was due, or answers a probe

A sketch that sleeps in its loop() may answer one request in each loop, long after the topics are known. Such
an answer is not a sign of a reset, but an introduction is.
"""

from __future__ import annotations

from enum import Enum, auto

from rostether.rosserial.topic_table import EndpointKey

# The time request of an introduction is sent right after the last announcement, even over networks.
CLOSING_S = 0.5

# The first announcement of an answer arrives right after its time request; a board takes longer to start.
OPENING_S = 0.25

# A request is lost if this time has passed since it was sent, and since the last answer.
LATE_ANSWER_S = 5.0

# An unconfigured board requests the time for each byte that it does not understand. These requests together
# are at most one answer; each takes 17 ms at 9600 baud.
REPEATED_S = 0.05


class TimeRequestMeaning(Enum):
    """The possible meanings of a board's time request."""

    ANSWER = auto()
    INTRODUCTION = auto()
    ALONE = auto()


class _Burst(Enum):
    NONE = auto()
    OPENED = auto()  # a time request came, which may begin an answer
    ANSWER = auto()  # and then announcements
    INTRODUCTION = auto()  # announcements came first


class TopicAnswers:
    """Counts the unanswered requests, and tracks the received bursts."""

    def __init__(self) -> None:
        self._waiting = 0
        self._waiting_until_s = 0.0
        self._burst = _Burst.NONE
        self._first: EndpointKey | None = None
        self._is_repetition = False
        self._received_at_s = float("-inf")
        self._damaged_s = float("-inf")

    def damaged(self, now_s: float) -> None:
        """Record a damaged frame: it may have been the time request that begins an answer."""
        self._damaged_s = now_s

    def requested(self, now_s: float) -> None:
        """Count a request that is sent."""
        self._waiting = self.waiting(now_s) + 1
        self._waiting_until_s = now_s + LATE_ANSWER_S

    def forget(self) -> None:
        """Forget all requests: the board was reset and has lost them."""
        self._waiting = 0
        self._burst = _Burst.NONE

    def waiting(self, now_s: float) -> int:
        """Return how many requests may still be answered."""
        return self._waiting if now_s < self._waiting_until_s else 0

    def announced(self, key: EndpointKey, now_s: float, *, is_known: bool) -> None:
        """Handle the announcement of an endpoint; `is_known`: it belongs to the last complete state."""
        if self._burst is _Burst.OPENED and now_s - self._received_at_s <= OPENING_S:
            self._burst = _Burst.ANSWER
            self._first = key
            self._waiting_until_s = now_s + LATE_ANSWER_S
        elif self._burst is not _Burst.ANSWER or self._first == key:
            # An answer has each announcement once.
            is_whole = now_s - self._damaged_s > CLOSING_S
            is_repeated = self._burst is not _Burst.INTRODUCTION or self._is_repetition
            self._is_repetition = is_known and is_whole and is_repeated
            self._burst = _Burst.INTRODUCTION
        self._received_at_s = now_s

    def time_requested(self, now_s: float, *, has_topics: bool) -> TimeRequestMeaning:
        """Handle a time request; `has_topics`: an answer would have announcements."""
        before, self._burst = self._burst, _Burst.NONE
        pause_s, self._received_at_s = now_s - self._received_at_s, now_s
        if before is _Burst.INTRODUCTION and pause_s <= CLOSING_S:
            return TimeRequestMeaning.INTRODUCTION if self._is_repetition else TimeRequestMeaning.ALONE
        if before is _Burst.OPENED and has_topics:
            # The last one was counted as an answer, but was not. This one may be; later ones are not.
            if pause_s <= OPENING_S:
                self._burst = _Burst.OPENED
            else:
                self._waiting = 0
            return TimeRequestMeaning.ALONE
        waiting = self.waiting(now_s)
        if not waiting:
            return TimeRequestMeaning.ALONE
        self._burst = _Burst.OPENED
        if before is not _Burst.OPENED or pause_s > REPEATED_S:
            self._waiting = waiting - 1
        return TimeRequestMeaning.ANSWER
