"""What established hosts say while a board announces its endpoints: people and scripts look for it."""

from __future__ import annotations

from rostether.bridge.reporter import Notices
from rostether.graph.ports import Level
from rostether.rosserial.events import (
    AnnouncementRefused,
    ServiceAnnounced,
    ServiceRole,
    TopicAnnounced,
    TopicRole,
)


class SetupLines:
    """The lines of one connection."""

    def __init__(self, notices: Notices) -> None:
        self._notices = notices
        self._noted_sizes: set[TopicRole] = set()

    def note_size(self, event: TopicAnnounced) -> None:
        """Say how large the board's buffer is, once for each direction."""
        if event.role in self._noted_sizes:
            return
        self._noted_sizes.add(event.role)
        what = "publish" if event.role is TopicRole.PUBLISHER else "subscribe"
        self._say(f"Note: {what} buffer size is {event.info.buffer_size} bytes")

    def topic(self, event: TopicAnnounced) -> None:
        """Say that a topic is served."""
        self._say(f"Setup {event.role.value} on {event.info.topic_name} [{event.info.message_type}]")

    def service(self, event: ServiceAnnounced) -> None:
        """Say that a service is served."""
        what = "server" if event.role is ServiceRole.SERVER else "client"
        self._say(f"Setup service {what} on {event.name} [{event.type}]")

    def refused(self, event: AnnouncementRefused) -> None:
        """Say why a topic is not served."""
        name = event.topic_name or "a topic without a name"
        self._notices.say(Level.ERROR, f"{name} [{event.message_type}] is not bridged: {event.reason}")

    def _say(self, text: str) -> None:
        self._notices.say(Level.INFO, text)
