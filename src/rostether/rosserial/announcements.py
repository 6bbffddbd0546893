"""Checks a device's announcements, one packet each, and keeps them in the table or among the refusals."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from rostether.rosserial.control_rate import ControlRate
from rostether.rosserial.events import (
    AnnouncementRefused,
    ControlFlood,
    DiscardReason,
    FrameDiscarded,
    HostEvent,
)
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_id import (
    SERVICE_CLIENT_REQUEST,
    SERVICE_SERVER_REQUEST,
    SERVICE_SERVER_RESPONSE,
)
from rostether.rosserial.topic_table import Announcement, EndpointKey, TopicTable, key_of

# The pause between two topic requests for one unknown id. An answer takes less time; messages may
# arrive every 10 ms.
FIRST_PAUSE_S = 1.0

# The pause grows to this for a device that never announces an id that it uses.
MAX_PAUSE_S = 60.0

# The limit of remembered ids: noise may look like messages on any id. Beyond it, the oldest is forgotten.
MAX_IDS = 256

# As many as the endpoints of a link; limits the reports about a device that keeps announcing new names.
MAX_REFUSALS = 256


class Announcements:
    """Enters announcements in `table`, and remembers refused ones and unknown topic ids."""

    def __init__(self, table: TopicTable, rate: ControlRate) -> None:
        self._table = table
        self._rate = rate
        self._refusals = Refusals()
        self._unknown_ids = UnknownIds()

    def handle_packet(
        self, kind: int, payload: bytes, now_s: float
    ) -> tuple[TopicInfo | None, list[HostEvent]]:
        """Handle a packet on reserved id `kind`; return the announcement (None if dropped) and the events."""
        info = TopicInfo.read(payload)
        if info is None:
            return None, [FrameDiscarded(DiscardReason.PACKET, payload, kind)]
        fault = info.fault()
        if fault is not None:
            discarded = FrameDiscarded(DiscardReason.REFUSED, payload)
            return info, [discarded, *self._refusals.refuse(kind, info, fault)]
        if not self._table.is_known(kind, info) and not self._rate.admit_change(now_s):
            return None, [ControlFlood(kind, 1)]
        changes = self._table.announce(kind, info)
        if changes is None:
            return None, [FrameDiscarded(DiscardReason.TOO_MANY, payload)]
        self._unknown_ids.forget(info.topic_id)
        self._refusals.forget(kind, info)
        return info, changes

    def withdraw_all_but(self, complete: Iterable[EndpointKey]) -> list[HostEvent]:
        """Keep only the endpoints that a settled negotiation found and that can be bridged."""
        return self._table.withdraw_all_but(frozenset(complete) - self._refusals.keys)

    def refuse_incomplete_services(self) -> list[HostEvent]:
        """Refuse service requests whose response was not announced, and vice versa."""
        return [*self._refusals.refuse_incomplete_services(self._table.incomplete_services())]

    def is_refused_sender(self, topic_id: int) -> bool:
        """Return whether the device sends messages on this id that are not bridged."""
        return self._refusals.is_sender(topic_id)

    def should_ask(self, topic_id: int, now_s: float) -> bool:
        """Return whether to request the topics again because of a message on an unknown id."""
        return self._unknown_ids.should_ask(topic_id, now_s)


class UnknownIds:
    """Remembers when the topics were requested because of each unknown id."""

    def __init__(self) -> None:
        self._pauses: dict[int, tuple[float, float]] = {}

    def should_ask(self, topic_id: int, now_s: float) -> bool:
        """Return whether a request because of this id is due; True doubles the pause before the next one."""
        again_s, pause_s = self._pauses.get(topic_id, (now_s, FIRST_PAUSE_S))
        if now_s < again_s:
            return False
        self._pauses.pop(topic_id, None)
        if len(self._pauses) >= MAX_IDS:
            del self._pauses[next(iter(self._pauses))]
        self._pauses[topic_id] = now_s + pause_s, min(2 * pause_s, MAX_PAUSE_S)
        return True

    def forget(self, topic_id: int) -> None:
        """Note that the id has been announced."""
        self._pauses.pop(topic_id, None)


class Refusals:
    """Remembers the refused announcements of one device."""

    def __init__(self) -> None:
        self._once: OrderedDict[Announcement, None] = OrderedDict()
        self._reported: set[Announcement] = set()

        # The refused endpoints of the device, which are not bridged.
        self.keys: set[EndpointKey] = set()

    def refuse(self, kind: int, info: TopicInfo, reason: str) -> list[AnnouncementRefused]:
        """Refuse an announcement; it is reported when it has arrived twice."""
        announcement = kind, info
        if announcement not in self._reported and announcement not in self._once:
            self._once[announcement] = None
            if len(self._once) > MAX_REFUSALS:
                self._once.popitem(last=False)
            return []
        self._once.pop(announcement, None)
        if len(self.keys) < MAX_REFUSALS:
            self.keys.add(key_of(kind, info))
        return self._report(announcement, reason)

    def refuse_incomplete_services(self, topics: Iterable[Announcement]) -> list[AnnouncementRefused]:
        """Record requests without a response, and responses without a request."""
        return [event for topic in topics for event in self._report(topic, _reason_for_incomplete(topic[0]))]

    def forget(self, kind: int, info: TopicInfo) -> None:
        """Remove an endpoint that has now been announced correctly."""
        self.keys.discard(key_of(kind, info))

    def is_sender(self, topic_id: int) -> bool:
        """Return whether the device sends messages on this id that are not bridged."""
        return EndpointKey(True, topic_id) in self.keys

    def _report(self, announcement: Announcement, reason: str) -> list[AnnouncementRefused]:
        if announcement in self._reported or len(self._reported) >= MAX_REFUSALS:
            return []
        self._reported.add(announcement)
        info = announcement[1]
        return [AnnouncementRefused(info.topic_name, info.message_type, reason)]


def _reason_for_incomplete(kind: int) -> str:
    role = "server" if kind in (SERVICE_SERVER_REQUEST, SERVICE_SERVER_RESPONSE) else "client"
    is_request = kind in (SERVICE_SERVER_REQUEST, SERVICE_CLIENT_REQUEST)
    has, lacks = ("request", "response") if is_request else ("response", "request")
    return (
        f"the service {role} announces its {has}, but no {lacks} of this name and type;"
        " announce both in the sketch"
    )
