"""Counts messages that do not fit their type, and so cannot be converted to ROS 2, while recording."""

from __future__ import annotations

from collections.abc import Callable


class UnfitMessages:
    """Counts dropped messages by topic, over all files; `report` receives one line for each topic."""

    def __init__(self, report: Callable[[str], None]) -> None:
        self.counts: dict[str, int] = {}
        self._report = report

    def add(self, topic: str, why: str) -> None:
        """Count one message."""
        if topic not in self.counts:
            self._report(f"WARNING: {topic}: messages that do not fit their type are left out: {why}")
        self.counts[topic] = self.counts.get(topic, 0) + 1
