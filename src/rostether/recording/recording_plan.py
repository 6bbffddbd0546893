"""Which topics a recording takes, and when its files and the recording end."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TopicChoice:
    """Which topics are recorded: names, or patterns, or all, or what a node subscribes to."""

    names: tuple[str, ...] = ()
    patterns: tuple[re.Pattern[str], ...] = ()
    exclude: re.Pattern[str] | None = None
    is_all: bool = False
    node: str = ""

    # Whether all topics are also those with a part that begins with `_`, which ROS 2 calls hidden.
    with_hidden: bool = True

    @property
    def is_searching(self) -> bool:
        """Whether topics that appear later count."""
        return self.is_all or bool(self.patterns) or bool(self.node)

    def includes(self, topic: str, subscribers: Sequence[str]) -> bool:
        """Return whether a topic that was found is recorded."""
        if self.exclude is not None and self.exclude.search(topic):
            return False
        return (
            (self.is_all and (self.with_hidden or "/_" not in topic))
            or topic in self.names
            or (bool(self.node) and self.node in subscribers)
            or any(pattern.fullmatch(topic) for pattern in self.patterns)
        )


@dataclass(frozen=True, slots=True)
class RecordLimits:
    """When a file is full, and when recording ends; None is never."""

    size_bytes: int | None = None
    duration_s: float | None = None
    is_splitting: bool = False
    max_splits: int | None = None
    messages_per_topic: int | None = None
