"""Announcements that cannot be bridged: distinguished from line damage, and reported once each.

One damaged frame in 256 passes its checksum, so one bad announcement may be noise. Noise does not repeat:
an announcement that comes twice is from the sketch, and its author gets a report why it is not bridged.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from typing import TypeAlias

from rostether.rosserial.events import AnnouncementRefused
from rostether.rosserial.packets import TopicInfo
from rostether.rosserial.topic_id import (
    SERVICE_CLIENT_REQUEST,
    SERVICE_SERVER_REQUEST,
    SERVICE_SERVER_RESPONSE,
)
from rostether.rosserial.topic_table import EndpointKey, key_of

# As many as endpoints; bounds the reports about a device that announces new names all the time.
MAX_REFUSALS = 256

_Announcement: TypeAlias = tuple[int, TopicInfo]


class Refusals:
    """Remembers the refused announcements of one device."""

    def __init__(self) -> None:
        self._once: OrderedDict[_Announcement, None] = OrderedDict()
        self._reported: set[_Announcement] = set()

        # Endpoints that the device is known to have and that are not bridged.
        self.keys: set[EndpointKey] = set()

    def refuse(self, kind: int, info: TopicInfo, reason: str) -> list[AnnouncementRefused]:
        """Take an announcement that is not believed; reported when it has come twice."""
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

    def refuse_lone_halves(self, halves: Iterable[tuple[int, TopicInfo]]) -> list[AnnouncementRefused]:
        """Record service halves whose other half will certainly not arrive."""
        return [event for half in halves for event in self._report(half, _half_reason(half[0]))]

    def forget(self, kind: int, info: TopicInfo) -> None:
        """Note that the endpoint has been announced as it should be."""
        self.keys.discard(key_of(kind, info))

    def is_sender(self, topic_id: int) -> bool:
        """Whether the device sends on this id what is not bridged."""
        return EndpointKey(True, topic_id) in self.keys

    def _report(self, announcement: _Announcement, reason: str) -> list[AnnouncementRefused]:
        if announcement in self._reported or len(self._reported) >= MAX_REFUSALS:
            return []
        self._reported.add(announcement)
        info = announcement[1]
        return [AnnouncementRefused(info.topic_name, info.message_type, reason)]


def _half_reason(kind: int) -> str:
    role = "server" if kind in (SERVICE_SERVER_REQUEST, SERVICE_SERVER_RESPONSE) else "client"
    halves = ("request", "response")
    has, lacks = halves if kind in (SERVICE_SERVER_REQUEST, SERVICE_CLIENT_REQUEST) else halves[::-1]
    return (
        f"the service {role} announces its {has} half, but no {lacks} half of this name and type;"
        " announce both in the sketch"
    )
