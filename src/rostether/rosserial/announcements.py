"""What a device announces, one packet at a time: judged, then kept in the table or among the refusals."""

from __future__ import annotations

from collections.abc import Iterable

from rostether.rosserial.control_rate import ControlRate
from rostether.rosserial.events import ControlFlood, DiscardReason, FrameDiscarded, HostEvent
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.refusals import Refusals
from rostether.rosserial.topic_table import EndpointKey, TopicTable
from rostether.rosserial.unknown_ids import UnknownIds


class Announcements:
    """Keeps `table` and knows what else the device sends on."""

    def __init__(self, table: TopicTable, rate: ControlRate) -> None:
        self._table = table
        self._rate = rate
        self._refusals = Refusals()
        self._unknown_ids = UnknownIds()

    def handle_packet(
        self, kind: int, payload: bytes, now_s: float
    ) -> tuple[TopicInfo | None, list[HostEvent]]:
        """Handle a packet on reserved id `kind`; return what the device has, None if that is not known."""
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
        """Keep what a settled negotiation found, and of that what can be bridged."""
        return self._table.withdraw_all_but(frozenset(complete) - self._refusals.keys)

    def refuse_lone_halves(self) -> list[HostEvent]:
        """Reject service halves whose other half will certainly not arrive."""
        return [*self._refusals.refuse_lone_halves(self._table.lone_halves())]

    def is_refused_sender(self, topic_id: int) -> bool:
        """Whether the device sends on this id what is not bridged."""
        return self._refusals.is_sender(topic_id)

    def should_ask(self, topic_id: int, now_s: float) -> bool:
        """Whether to ask for the topics again because of a message on an id that is not known."""
        return self._unknown_ids.should_ask(topic_id, now_s)
