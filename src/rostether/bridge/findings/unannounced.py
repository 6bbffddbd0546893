"""Messages with topic ids that the board has not announced."""

from __future__ import annotations

from rostether.bridge.findings.finding import Code, Finding, warning
from rostether.rosserial.events import UnknownTopicId

# A lost announcement is repeated within a second; after this time, the board never sends it.
UNKNOWN_S = 10.0
# Noise that passes as a frame has a random id, which does not come again.
MIN_UNKNOWN = 2
# A sketch has fewer topics. Noise must not fill the memory.
MAX_UNKNOWN_IDS = 100


class UnannouncedMessages:
    """The messages of one connection whose topic ids were not announced."""

    def __init__(self) -> None:
        # By topic id: the time of the first message, and how many came.
        self._messages: dict[int, tuple[float, int]] = {}

    def record(self, event: UnknownTopicId, now_s: float) -> None:
        """Count messages with an unknown id."""
        first_s, count = self._messages.get(event.topic_id, (now_s, 0))
        if count or len(self._messages) < MAX_UNKNOWN_IDS:
            self._messages[event.topic_id] = first_s, count + event.count

    def announced(self, topic_id: int) -> None:
        """Forget the messages of an id that was announced late."""
        self._messages.pop(topic_id, None)

    def find(self, now_s: float) -> Finding | None:
        """Return the finding about an id that came again and was not announced in time."""
        for topic_id, (first_s, count) in self._messages.items():
            if count >= MIN_UNKNOWN and now_s - first_s >= UNKNOWN_S:
                return warning(
                    Code.UNANNOUNCED_MESSAGES,
                    f"{count} messages have topic id {topic_id}, which the board never announces",
                    "call nh.advertise() for every publisher in setup(), before the first nh.spinOnce()",
                )
        return None
