"""When to ask a device for its topics, and when to believe that all of them have been heard.

There is no acknowledgement: a request may be lost, and so may any of the announcements that answer it. A
round is one request and the burst that answers it. What a single round tells is taken as complete only when
later rounds bring nothing new: one more on a clean line, three where anything hints at loss (rounds that
differ, damage, gaps in the ids, half a service, less than before), none if the round repeats exactly what
was settled before.

    phase       input         next        what happens
    IDLE        ASK           ASKED       send a request, begin a negotiation
    ASKED       UNANSWERED    ASKED       send the next request
    ASKED       ANSWER        LISTENING   a burst begins: a time request first, then the announcements
    LISTENING   ANSWER        LISTENING   the burst goes on: wait until it has been quiet for a while
    LISTENING   MORE_NEEDED   ASKED       the round is over, send the next request
    LISTENING   ENOUGH        SETTLED
    SETTLED     ANSWER        LISTENING   announcements nobody asked for, or a late answer
    SETTLED     ASK           ASKED       send a request, begin a negotiation

While the burst flows nothing is sent: at 57600 baud fifty announcements take 0.8 s, and the board listens
badly while it talks. A device that has not been heard at all is asked in both protocol versions in turn.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import TypeAlias

from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_id import (
    ANNOUNCEMENTS,
    FIRST_USER_ID,
    SERVICE_CLIENT_REQUEST,
    SERVICE_CLIENT_RESPONSE,
    SERVICE_SERVER_REQUEST,
    SERVICE_SERVER_RESPONSE,
)
from rostether.rosserial.topic_table import EndpointKey, key_of

Announcement: TypeAlias = tuple[int, TopicInfo]

QUIET_S = 0.1
"""A burst is over after this long without a sign of it: one announcement takes 0.1 s at 9600 baud."""

SEARCH_STEPS = ((2, 0.2), (2, 0.2), (1, 0.3), (2, 0.3), (1, 0.5), (2, 0.5))
"""(version to ask in, wait after it) while nothing is heard; the last two go on forever.

Dense at first, because one request in twenty may be lost on the way; then slow enough that the stack of
requests in the 64 bytes of a board whose sketch sleeps a second between spins stays small, and quick enough
that a board which comes up later is found within a second.
"""

RETRY_S = 0.2
"""Waiting for an answer on a line that works; most boards answer within 20 ms (ANSWER_MARGIN: others)."""

MAX_RETRY_S = 1.0
"""Unanswered requests get rarer up to this: a user expects a lost board back within two seconds."""

ANSWER_MARGIN = 1.5
"""A sketch that spins rarely answers late every time: wait this many times its last answer's delay."""

CLEAN_CONFIRMATIONS = 1
LOSSY_CONFIRMATIONS = 3
"""At 5 % loss an announcement is missed four times in a row once in 160,000 cases."""

EMPTY_CONFIRMATIONS = 2
"""A device without endpoints is rare, one whose only announcement was lost is not."""

LATE_ANSWER_S = 5.0
"""A request unanswered for this long was lost, not delayed."""


class Phase(Enum):
    """Where a negotiation stands."""

    IDLE = auto()
    ASKED = auto()
    LISTENING = auto()
    SETTLED = auto()


class Input(Enum):
    """What can happen to a negotiation."""

    ASK = auto()
    ANSWER = auto()
    UNANSWERED = auto()
    MORE_NEEDED = auto()
    ENOUGH = auto()


TRANSITIONS = {
    (Phase.IDLE, Input.ASK): Phase.ASKED,
    (Phase.ASKED, Input.UNANSWERED): Phase.ASKED,
    (Phase.ASKED, Input.ANSWER): Phase.LISTENING,
    (Phase.LISTENING, Input.ANSWER): Phase.LISTENING,
    (Phase.LISTENING, Input.MORE_NEEDED): Phase.ASKED,
    (Phase.LISTENING, Input.ENOUGH): Phase.SETTLED,
    (Phase.SETTLED, Input.ANSWER): Phase.LISTENING,
    (Phase.SETTLED, Input.ASK): Phase.ASKED,
}
"""Every other pair leaves the phase as it is and does nothing."""


class Negotiation:
    """One device's negotiations, one after the other. Told what came and when; asks by `take_request`."""

    def __init__(self) -> None:
        self.phase = Phase.IDLE
        self.version: int | None = None
        self.round_trip_s: float | None = None
        self.began_s = 0.0
        self.rounds = 0
        self.requests = 0
        self._settled: dict[EndpointKey, Announcement] = {}
        self._heard: dict[EndpointKey, Announcement] = {}
        self._round: set[EndpointKey] = set()
        self._has_news = False
        self._quiet_rounds = 0
        self._is_lossy = False
        self._unanswered = 0
        self._late_answers = 0
        self._asked_in: int | None = None
        self._asked_s = 0.0
        self._first_asked_s = 0.0
        self._request: int | None = None
        self._due_s: float | None = None
        self._answer_delay_s = 0.0
        self._search_step = 0

    @property
    def is_settled(self) -> bool:
        """Whether all topics are taken to be known."""
        return self.phase is Phase.SETTLED

    @property
    def heard(self) -> frozenset[EndpointKey]:
        """What has been announced in this negotiation."""
        return frozenset(self._heard)

    def expects_answer(self, now_s: float) -> bool:
        """Whether a time request that comes now answers a topic request, perhaps late."""
        if self.phase is Phase.SETTLED:
            return self._late_answers > 0 and now_s < self._asked_s + LATE_ANSWER_S
        return self.phase is not Phase.IDLE

    def ask(self, now_s: float, *, is_lossy: bool = False) -> None:
        """Begin a negotiation, unless one goes on. `is_lossy`: something was lost before."""
        if (self.phase, Input.ASK) in TRANSITIONS:
            self._begin(now_s)
            self._search_step = 0
            self._is_lossy = is_lossy
            self._send(Input.ASK, now_s)

    def set_version(self, version: int | None, now_s: float) -> None:
        """Learn the device's version (ask at once if the last request was in the other one), or forget it."""
        was_asked_in, self.version = self._asked_in, version
        if version is not None and self.phase is Phase.ASKED and was_asked_in != version:
            self._send(Input.UNANSWERED, now_s)

    def take_request(self) -> int | None:
        """Return the version in which to send a topic request now, once."""
        request, self._request = self._request, None
        return request

    def note_damage(self) -> None:
        """Learn that a damaged frame came: what it was may be missing."""
        self._is_lossy = True

    def answered(self, now_s: float) -> None:
        """Learn that the device began to answer."""
        if self.phase is Phase.ASKED:
            delay_s = now_s - (self._asked_s if self._unanswered == 1 else self._first_asked_s)
            if self._unanswered == 1:
                self.round_trip_s = delay_s
            self._answer_delay_s = delay_s
            self._late_answers += self._unanswered - 1
            self._open_round()
        elif self.phase is Phase.SETTLED:
            late_answers = max(self._late_answers - 1, 0)
            self._begin(now_s)
            self._late_answers = late_answers
            self._open_round()
        if self._advance(Input.ANSWER):
            self._due_s = now_s + QUIET_S

    def announced(self, kind: int, info: TopicInfo, now_s: float) -> None:
        """Take one announcement."""
        self.answered(now_s)
        key = key_of(kind, info)
        self._round.add(key)
        if self._heard.get(key) != (kind, info):
            self._heard[key] = kind, info
            self._has_news = True

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`."""
        return self._due_s

    def handle_timer(self, now_s: float, *, is_flowing: bool) -> bool:
        """Do what is due; True when that settled it. `is_flowing`: an announcement is just coming in."""
        if self._due_s is None or now_s < self._due_s:
            return False
        if self.phase is Phase.ASKED:
            is_quick = self._answer_delay_s < RETRY_S / 2
            self._is_lossy = self._is_lossy or (self.version is not None and is_quick)
            self._send(Input.UNANSWERED, now_s)
            return False
        if is_flowing:
            self._due_s = now_s + QUIET_S
            return False
        if self._has_enough():
            self._advance(Input.ENOUGH)
            self._settled = dict(self._heard)
            self._due_s = None
            return True
        self._send(Input.MORE_NEEDED, now_s)
        return False

    def _advance(self, what: Input) -> bool:
        following = TRANSITIONS.get((self.phase, what))
        if following is None:
            return False
        self.phase = following
        return True

    def _begin(self, now_s: float) -> None:
        """Forget what the negotiation before this one heard."""
        self.began_s = now_s
        self.rounds = 0
        self.requests = 0
        self._heard = {}
        self._round = set()
        self._has_news = False
        self._quiet_rounds = 0
        self._is_lossy = False
        self._unanswered = 0
        self._late_answers = 0
        self._asked_in = None
        self._asked_s = self._first_asked_s = now_s

    def _open_round(self) -> None:
        self._round = set()
        self._has_news = False
        self._unanswered = 0

    def _send(self, why: Input, now_s: float) -> None:
        if not self._advance(why):
            return
        if self.version is None:
            step = self._search_step
            if step >= len(SEARCH_STEPS):
                step = len(SEARCH_STEPS) - 2 + step % 2
            self._asked_in, wait_s = SEARCH_STEPS[step]
            self._search_step += 1
        else:
            self._asked_in = self.version
            patience_s = max(RETRY_S, ANSWER_MARGIN * self._answer_delay_s)
            wait_s = max(patience_s, min(patience_s * 2**self._unanswered, MAX_RETRY_S))
        if self._unanswered == 0:
            self._first_asked_s = now_s
        self._asked_s = now_s
        self._unanswered += 1
        self.requests += 1
        self._request = self._asked_in
        self._due_s = now_s + wait_s

    def _has_enough(self) -> bool:
        """Judge the round that is over."""
        if not self._round and (self._heard or self._settled):
            self._is_lossy = True
            return False
        self.rounds += 1
        missing = len(self._heard) > len(self._round) or not self._settled.keys() <= self._heard.keys()
        self._is_lossy = self._is_lossy or missing
        self._quiet_rounds = 0 if self._has_news or self.rounds == 1 else self._quiet_rounds + 1
        if self._is_lossy or not _looks_whole(self._heard):
            needed = LOSSY_CONFIRMATIONS
        elif not self._heard:
            needed = EMPTY_CONFIRMATIONS
        else:
            needed = 0 if self._heard == self._settled else CLEAN_CONFIRMATIONS
        return self._quiet_rounds >= needed


def _looks_whole(heard: dict[EndpointKey, Announcement]) -> bool:
    """Whether ids follow each other in both directions, and services have both halves."""
    for sends in (False, True):
        numbers = [key.topic_id for key in heard if key.sends is sends]
        if numbers and max(numbers) - min(numbers) >= len(numbers):
            return False
        if numbers and not sends and min(numbers) > FIRST_USER_ID:
            return False
    names: dict[int, list[str]] = {kind: [] for kind in ANNOUNCEMENTS}
    for kind, info in heard.values():
        names[kind].append(info.topic_name)
    return all(
        sorted(names[one]) == sorted(names[other])
        for one, other in (
            (SERVICE_SERVER_REQUEST, SERVICE_SERVER_RESPONSE),
            (SERVICE_CLIENT_REQUEST, SERVICE_CLIENT_RESPONSE),
        )
    )
