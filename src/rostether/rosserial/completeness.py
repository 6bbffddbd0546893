"""Decides after each round whether all announcements of a device were received.

A round is one topic request and the burst that answers it; any part of both may be lost. The announcements of
a round count as complete if later rounds announce nothing new: one more round on a clean line, three if there
is a sign of loss, none if the round equals the last complete state. Signs of loss are rounds that differ,
damage, gaps in the ids, a service without request or response, and fewer announcements than before.
"""

from __future__ import annotations

from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_id import ANNOUNCEMENTS
from rostether.rosserial.topic_table import SERVICE_KINDS, Announcement, EndpointKey, key_of

# Each costs a healthy board one more burst, so one must be enough.
CLEAN_CONFIRMATIONS = 1

# At 5 % loss an announcement is missed four times in a row once in 160,000 cases.
LOSSY_CONFIRMATIONS = 3

# An announcement missing in this many equal rounds was not lost: the device no longer has it.
EQUAL_ROUNDS = 4

# A device without endpoints is rare; a device whose only announcement was lost is not.
EMPTY_CONFIRMATIONS = 2

# Sixteen times the endpoints of a link; a device that invents new ids cannot fill the memory.
MAX_ANNOUNCED = 4096


class Completeness:
    """The announcements of one device, in this negotiation and at the end of the last one."""

    def __init__(self) -> None:
        self.rounds = 0
        self.is_lossy = False
        self._complete: dict[EndpointKey, Announcement] = {}
        self._announced: dict[EndpointKey, Announcement] = {}
        self._round: set[EndpointKey] = set()
        self._previous_round: set[EndpointKey] = set()
        self._equal_rounds = 0
        self._has_changed = False
        self._quiet_rounds = 0
        self._before_close = (0, 0)

    @property
    def endpoints(self) -> frozenset[EndpointKey]:
        """The endpoints of the last complete state."""
        return frozenset(self._complete)

    @property
    def has_announcements(self) -> bool:
        """Whether the device has ever announced anything."""
        return bool(self._announced or self._complete)

    def begin(self, *, is_lossy: bool) -> None:
        """Begin a negotiation. `is_lossy`: data was lost before."""
        self.rounds = 0
        self.is_lossy = is_lossy
        self._announced = {}
        self._quiet_rounds = 0
        self._previous_round = set()
        self._equal_rounds = 0
        self.open_round()

    def open_round(self) -> None:
        """Begin a round."""
        self._round = set()
        self._has_changed = False

    def resume_round(self) -> None:
        """Continue the last round: a part of its burst arrived late."""
        self.rounds, self._quiet_rounds = self._before_close

    def is_known(self, kind: int, info: TopicInfo) -> bool:
        """Return whether the announcement equals the last complete state."""
        return self._complete.get(key_of(kind, info)) == (kind, info)

    def is_continued_by(self, kind: int, info: TopicInfo) -> bool:
        """Return whether the announcement can belong to the last round's burst, which did not have it."""
        return bool(self._round) and key_of(kind, info) not in self._round

    def note_announcement(self, kind: int, info: TopicInfo) -> None:
        """Add an announcement to this round."""
        key = key_of(kind, info)
        if key not in self._announced and len(self._announced) >= MAX_ANNOUNCED:
            return
        self._round.add(key)
        if self._announced.get(key) != (kind, info):
            self._announced[key] = kind, info
            self._has_changed = True

    def close_round(self) -> bool:
        """End the round; return whether all announcements were received."""
        if not self._round and (self._announced or self._complete):
            self.is_lossy = True
            return False
        self._before_close = self.rounds, self._quiet_rounds
        self.rounds += 1
        is_missing = (
            len(self._announced) > len(self._round) or not self._complete.keys() <= self._announced.keys()
        )
        self.is_lossy = self.is_lossy or is_missing
        self._quiet_rounds = 0 if self._has_changed or self.rounds == 1 else self._quiet_rounds + 1
        self._equal_rounds = self._equal_rounds + 1 if self._round == self._previous_round else 1
        self._previous_round = self._round
        if self._quiet_rounds < self._needed_rounds():
            return False
        if len(self._announced) > len(self._round) and self._equal_rounds >= LOSSY_CONFIRMATIONS:
            if self._equal_rounds < EQUAL_ROUNDS:
                return False
            self._announced = {key: self._announced[key] for key in self._round if key in self._announced}
        return True

    def accept(self, *, is_confirmed: bool) -> None:
        """Accept the announcements as the complete state; without confirmation, only add them to it."""
        self._complete = dict(self._announced) if is_confirmed else self._complete | self._announced

    def _needed_rounds(self) -> int:
        if self.is_lossy:
            return LOSSY_CONFIRMATIONS
        if not self._announced:
            return EMPTY_CONFIRMATIONS
        if self._announced == self._complete:
            return 0
        return CLEAN_CONFIRMATIONS if _looks_complete(self._announced) else LOSSY_CONFIRMATIONS


def _looks_complete(announced: dict[EndpointKey, Announcement]) -> bool:
    """Return whether the ids have no gaps in either direction, and each service has request and response."""
    for sends in (False, True):
        numbers = [key.topic_id for key in announced if key.sends is sends]
        if numbers and max(numbers) - min(numbers) >= len(numbers):
            return False
    names: dict[int, list[str]] = {kind: [] for kind in ANNOUNCEMENTS}
    for kind, info in announced.values():
        names[kind].append(info.topic_name)
    return all(
        sorted(names[request]) == sorted(names[response]) for request, response in SERVICE_KINDS.values()
    )
