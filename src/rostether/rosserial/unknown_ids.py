"""When to ask for the topics again because messages come on an id that was never announced."""

from __future__ import annotations

# Between two questions about one id: an answer takes less, but a message may come every 10 ms.
FIRST_PAUSE_S = 1.0

# A device that never announces an id it uses is asked about it ever more rarely.
MAX_PAUSE_S = 60.0

# Ids remembered; noise that passes for messages forgets the oldest.
MAX_IDS = 256


class UnknownIds:
    """Remembers which unknown ids were asked about when."""

    def __init__(self) -> None:
        self._pauses: dict[int, tuple[float, float]] = {}

    def should_ask(self, topic_id: int, now_s: float) -> bool:
        """Whether it is time to ask about this id; True doubles the pause before the next time."""
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
