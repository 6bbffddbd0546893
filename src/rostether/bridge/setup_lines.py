"""The lines that established hosts print while a board announces its endpoints: users and scripts search for
them.

The lines of a board that keeps reconnecting or changing its topics are limited to a readable number.
"""

from __future__ import annotations

from collections.abc import Callable

from rostether.bridge.reporter import Notices
from rostether.graph.ports import Level
from rostether.rosserial.events import (
    AnnouncementRefused,
    ServiceAnnounced,
    ServiceRole,
    TopicAnnounced,
    TopicRole,
)

# Lines reported at once: twice those of the largest board, which has 256 endpoints.
SAVED_LINES = 600
# After that limit, one line per this many seconds.
LINE_PERIOD_S = 5.0
# After lines were omitted, this many must be available again: a part of a board's topics is not useful.
RESUME_LINES = 60
# How often the number of omitted lines is reported.
SUMMARY_PERIOD_S = 60.0


class SetupLines:
    """The lines of one board, over all of its connections; `clock` in seconds."""

    def __init__(self, notices: Notices, clock: Callable[[], float]) -> None:
        self._notices = notices
        self._clock = clock
        self._noted_sizes: set[TopicRole] = set()
        self._room = float(SAVED_LINES)
        self._counted_s = clock()
        self._left_out = 0
        self._summed_s = float("-inf")

    def connected(self) -> None:
        """Record that a connection begins."""
        self._noted_sizes.clear()

    def note_size(self, event: TopicAnnounced) -> None:
        """Report the size of the board's buffer, once for each direction."""
        if event.role in self._noted_sizes:
            return
        self._noted_sizes.add(event.role)
        what = "publish" if event.role is TopicRole.PUBLISHER else "subscribe"
        self._report(f"Note: {what} buffer size is {event.info.buffer_size} bytes")

    def topic(self, event: TopicAnnounced) -> None:
        """Report that a topic is served."""
        self._report(f"Setup {event.role.value} on {event.info.topic_name} [{event.info.message_type}]")

    def service(self, event: ServiceAnnounced) -> None:
        """Report that a service is served."""
        what = "server" if event.role is ServiceRole.SERVER else "client"
        self._report(f"Setup service {what} on {event.name} [{event.type}]")

    def refused(self, event: AnnouncementRefused) -> None:
        """Report why a topic is not served."""
        name = event.topic_name or "a topic without a name"
        self._report(f"{name} [{event.message_type}] is not bridged: {event.reason}", Level.ERROR)

    def _report(self, text: str, level: Level = Level.INFO) -> None:
        now_s = self._clock()
        self._room = min(self._room + (now_s - self._counted_s) / LINE_PERIOD_S, float(SAVED_LINES))
        self._counted_s = now_s
        if self._room < (RESUME_LINES if self._left_out else 1):
            self._leave_out(now_s)
            return
        self._room -= 1
        self._left_out = 0
        self._notices.report(level, text)

    def _leave_out(self, now_s: float) -> None:
        self._left_out += 1
        if now_s - self._summed_s >= SUMMARY_PERIOD_S:
            self._summed_s = now_s
            self._notices.report(
                Level.WARN,
                f"the board announces its topics again and again; these lines are omitted ({self._left_out}"
                " so far); check its power and cable, and that no other board has the same name",
            )
