"""Decides when to ask a device for its topics, and when all announcements have probably been received.

There is no acknowledgement, so completeness.py checks the announcements after each round. A round is one
request and the burst that answers it.

    phase       input         next        what happens
    IDLE        ASK           ASKED       send a request, begin a negotiation
    ASKED       UNANSWERED    ASKED       send the next request
    ASKED       ENOUGH        SETTLED     it answered only once: accept that answer
    ASKED       ANSWER        LISTENING   a burst begins: a time request first, then the announcements (or
                                          the last burst continues, and its round)
    LISTENING   ANSWER        LISTENING   the burst continues: wait for a pause
    LISTENING   MORE_NEEDED   ASKED       the round is over, send the next request
    LISTENING   ENOUGH        SETTLED
    SETTLED     ANSWER        LISTENING   announcements without a request, or late ones
    SETTLED     ASK           ASKED       send a request, begin a negotiation

During a burst nothing is sent: at 57600 baud fifty announcements take 0.8 s, and a board that sends may lose
received bytes. The pause that ends a burst depends on the pauses within it. The requests to a device that
has sent nothing alternate between the two protocol versions. Requests are repeated less often while
earlier ones may fill the UART of a sketch that sleeps.
"""

from __future__ import annotations

import logging
from enum import Enum, auto

from rostether.rosserial.completeness import Completeness
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_answers import TimeRequestMeaning, TopicAnswers
from rostether.rosserial.topic_table import EndpointKey, key_of
from rostether.rosserial.unread_bytes import REQUEST_BYTES, UnreadBytes

_LOG = logging.getLogger(__name__)

# A burst ends after a pause of this length: one announcement takes 0.1 s at 9600 baud.
QUIET_S = 0.1

# If a board pauses longer between announcements, the wait is its longest pause times this factor.
QUIET_MARGIN = 1.5

# With a longer pause between them, announcements answer two requests.
MAX_QUIET_S = 1.0

# At 30 % loss, one announcement in two million is lost in every round. Rounds that still differ are accepted.
MAX_ROUNDS = 12

# (version of the request, pause after it) until the device answers; the last two repeat forever. Frequent at
# first, because one request in twenty may be lost. Less frequent later: if a sketch sleeps a second between
# spins, the requests collect in the 64 bytes of its UART's buffer. But a board that starts later must be
# found within a second.
SEARCH_STEPS = ((2, 0.2), (2, 0.2), (1, 0.3), (2, 0.3), (1, 0.5), (2, 0.5))

# The wait for an answer on a working line; most boards answer within 20 ms. ANSWER_MARGIN is for slow ones.
RETRY_S = 0.2

# With this growth, three requests lost in a row (once in 8000 cases at 5 % loss) cost less than a second.
RETRY_GROWTH = 1.5

# The longest interval between unanswered requests: a user expects a lost board back within two seconds.
MAX_RETRY_S = 1.0

# A sketch that rarely spins answers late every time: wait for its last answer's delay times this factor.
ANSWER_MARGIN = 1.5

# The number of requests to a device that answered the first one, but no later one: a few seconds.
MAX_UNANSWERED = 6


class Phase(Enum):
    """The phase of a negotiation."""

    IDLE = auto()
    ASKED = auto()
    LISTENING = auto()
    SETTLED = auto()


class Input(Enum):
    """The inputs of the phase table."""

    ASK = auto()
    ANSWER = auto()
    UNANSWERED = auto()
    MORE_NEEDED = auto()
    ENOUGH = auto()


# All other pairs change nothing.
TRANSITIONS = {
    (Phase.IDLE, Input.ASK): Phase.ASKED,
    (Phase.ASKED, Input.UNANSWERED): Phase.ASKED,
    (Phase.ASKED, Input.ENOUGH): Phase.SETTLED,
    (Phase.ASKED, Input.ANSWER): Phase.LISTENING,
    (Phase.LISTENING, Input.ANSWER): Phase.LISTENING,
    (Phase.LISTENING, Input.MORE_NEEDED): Phase.ASKED,
    (Phase.LISTENING, Input.ENOUGH): Phase.SETTLED,
    (Phase.SETTLED, Input.ANSWER): Phase.LISTENING,
    (Phase.SETTLED, Input.ASK): Phase.ASKED,
}


class Negotiation:
    """The negotiations of one device, controlled by received frames and their times.

    `name` is for the log.
    """

    def __init__(self, name: str = "", unread: UnreadBytes | None = None) -> None:
        self.phase = Phase.IDLE
        self._name = name
        self._unread = unread or UnreadBytes()
        self.version: int | None = None
        self.round_trip_s: float | None = None
        self.requests = 0
        self._completeness = Completeness()
        self._unanswered = 0
        self._answers = TopicAnswers()
        self._asked_in: int | None = None
        self._asked_s = 0.0
        self._first_asked_s = 0.0
        self._answer_delay_s: float | None = None
        self._answered_s = 0.0
        self._search_step = 0
        self._has_rechecked = False
        self._quiet_s = QUIET_S
        self._received_at_s = float("-inf")
        self._bursts = 0
        self._request: int | None = None
        self._due_s: float | None = None

    @property
    def is_settled(self) -> bool:
        """Whether all topics are considered known."""
        return self.phase is Phase.SETTLED

    @property
    def is_listening(self) -> bool:
        """Whether a burst is in progress."""
        return self.phase is Phase.LISTENING

    @property
    def rounds(self) -> int:
        """How many rounds of this negotiation were answered."""
        return self._completeness.rounds

    @property
    def endpoints(self) -> frozenset[EndpointKey]:
        """All endpoints of the device, once settled."""
        return self._completeness.endpoints

    def ask(self, now_s: float, *, is_lossy: bool = False) -> None:
        """Start a negotiation, unless one is running. `is_lossy`: data was lost before."""
        if (self.phase, Input.ASK) in TRANSITIONS:
            self._begin(now_s, is_lossy=is_lossy)
            self._send(Input.ASK, now_s)

    def set_version(self, version: int | None, now_s: float) -> None:
        """Set the device's version, or forget it (None); ask again if the last request had another one."""
        self.version = version
        self._search_step = 0
        if version is None:
            self._quiet_s = QUIET_S
        elif self.phase is Phase.ASKED and self._asked_in != version:
            self._send(Input.UNANSWERED, now_s)

    def pop_request(self) -> int | None:
        """Return the version of a topic request that is to be sent now, once; None if none is."""
        request, self._request = self._request, None
        if request is not None:
            self._answers.requested(self._asked_s)
        return request

    def note_damage(self, now_s: float) -> None:
        """Record a damaged frame; on a line that was clean before, another round confirms the topics."""
        self._answers.damaged(now_s)
        if self.phase is not Phase.SETTLED:
            self._completeness.is_lossy = True
        elif not self._completeness.is_lossy and not self._has_rechecked:
            self._has_rechecked = True
            self.ask(now_s)

    def forget_requests(self) -> None:
        """Forget earlier requests: the board was reset and will not answer them."""
        self._answers.forget()

    def time_requested(self, now_s: float) -> TimeRequestMeaning:
        """Handle a time request, which may begin an answer; return its meaning."""
        has_topics = self._completeness.has_announcements
        meaning = self._answers.time_requested(now_s, has_topics=has_topics)
        if meaning is TimeRequestMeaning.ANSWER:
            self._answered_s = now_s
        if self.phase is Phase.SETTLED:
            return meaning
        if self.phase is Phase.LISTENING:
            if self._unanswered == 0 and meaning is TimeRequestMeaning.ANSWER:
                # So no request was lost: the sketch is slow, and handles all requests at once when it spins.
                self._answer_delay_s = max(self._answer_delay_s or 0.0, now_s - self._first_asked_s)
            self._unanswered = 0
        elif meaning is TimeRequestMeaning.ANSWER:
            self._answer_delay_s = now_s - self._asked_s
            if self._unanswered == 1:
                self.round_trip_s = self._answer_delay_s
        self._handle_answer(now_s)
        return meaning

    def announced(self, kind: int, info: TopicInfo, now_s: float) -> None:
        """Handle an announcement, even one that is refused: it was not lost."""
        is_known = self._completeness.is_known(kind, info)
        self._answers.announced(key_of(kind, info), now_s, is_known=is_known)
        if self.phase is Phase.SETTLED and is_known:
            return
        pause_s = now_s - self._received_at_s
        is_same_burst = self.phase is not Phase.ASKED
        if self.phase is Phase.ASKED and pause_s <= MAX_QUIET_S:
            is_same_burst = self._completeness.is_continued_by(kind, info)
            if is_same_burst:
                self._completeness.resume_round()
                self._advance(Input.ANSWER)
        if is_same_burst and pause_s <= MAX_QUIET_S:
            self._quiet_s = max(self._quiet_s, min(QUIET_MARGIN * pause_s, MAX_QUIET_S))
        self._handle_answer(now_s)
        self._completeness.note_announcement(kind, info)

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, None if nothing is scheduled."""
        return self._due_s

    def handle_timer(self, now_s: float, *, is_flowing: bool) -> bool:
        """Do all work that is due; return whether this settles the negotiation.

        `is_flowing`: an announcement is being received.
        """
        if self._due_s is None or now_s < self._due_s:
            return False
        if self.phase is Phase.ASKED:
            return self._handle_no_answer(now_s)
        if is_flowing:
            self._due_s = now_s + self._quiet_s
            return False
        if self._completeness.close_round():
            return self._settle(is_confirmed=True)
        self._bursts += 1
        if self._bursts >= MAX_ROUNDS and self._completeness.has_announcements:
            return self._settle(is_confirmed=False)
        if self.requests == 0:
            # Without a request, a device may announce only a part: endpoints missing in it were not lost.
            self._completeness.begin(is_lossy=False)
        self._send_if_room(Input.MORE_NEEDED, now_s)
        return False

    def _handle_answer(self, now_s: float) -> None:
        """Record that the device answers or continues to answer."""
        if self.phase is Phase.ASKED:
            self._unanswered = 0
            self._completeness.open_round()
        elif self.phase is Phase.SETTLED:
            self._begin(now_s, is_lossy=False)
        if self._advance(Input.ANSWER):
            self._due_s = now_s + self._quiet_s
        self._received_at_s = now_s

    def _handle_no_answer(self, now_s: float) -> bool:
        if self.version is not None:
            if self._answer_delay_s is not None and self._answer_delay_s < RETRY_S / 2:
                self._completeness.is_lossy = True
            if self._unanswered >= MAX_UNANSWERED and self._completeness.has_announcements:
                return self._settle(is_confirmed=False)
        self._send_if_room(Input.UNANSWERED, now_s)
        return False

    def _settle(self, *, is_confirmed: bool) -> bool:
        self._advance(Input.ENOUGH)
        self._completeness.accept(is_confirmed=is_confirmed)
        self._unanswered = 0
        self._due_s = None
        return True

    def _begin(self, now_s: float, *, is_lossy: bool) -> None:
        """Start a new negotiation."""
        self._completeness.begin(is_lossy=is_lossy)
        self._asked_s = self._first_asked_s = now_s
        self.requests = 0
        self._bursts = 0
        self._unanswered = 0

    def _send(self, why: Input, now_s: float) -> None:
        self._advance(why)
        if self.version is None:
            step = self._search_step
            if step >= len(SEARCH_STEPS):
                step = len(SEARCH_STEPS) - 2 + step % 2
            self._asked_in, wait_s = SEARCH_STEPS[step]
            self._search_step += 1
        else:
            self._asked_in = self.version
            patience_s = max(RETRY_S, ANSWER_MARGIN * (self._answer_delay_s or 0.0))
            wait_s = max(patience_s, min(patience_s * RETRY_GROWTH**self._unanswered, MAX_RETRY_S))
        if self._unanswered == 0:
            self._first_asked_s = now_s
        self._asked_s = now_s
        self._unanswered += 1
        self.requests += 1
        self._request = self._asked_in
        self._due_s = now_s + wait_s

    def _send_if_room(self, why: Input, now_s: float) -> None:
        """Send a request, unless earlier ones may fill the UART of a sketch that sleeps."""
        room_bytes = self._unread.room_bytes
        if self.version is None or room_bytes is None:
            must_wait = False
        elif why is Input.MORE_NEEDED:
            must_wait = room_bytes < REQUEST_BYTES and self._asked_s >= self._answered_s
        else:
            is_early = now_s < self._asked_s + MAX_RETRY_S
            must_wait = room_bytes < REQUEST_BYTES or (is_early and self._unread.are_many)
        if must_wait:
            self._advance(why)
            self._due_s = now_s + RETRY_S
        else:
            self._send(why, now_s)

    def _advance(self, what: Input) -> bool:
        following = TRANSITIONS.get((self.phase, what))
        if following is None:
            return False
        if following is not self.phase:
            _LOG.debug(
                "%s: negotiation %s -> %s (%s)", self._name, self.phase.name, following.name, what.name
            )
        self.phase = following
        return True
