"""The topics to record, the limits of each file and of the whole recording, and its progress."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from msgspec import Struct, field


class TopicChoice(Struct, frozen=True):
    """The topics to record: names, patterns, all topics, or the subscriptions of a node.

    `exclude` has priority over all of them. Without `with_hidden`, "all topics" omits ROS 2's hidden topics,
    which have a part that starts with `_`.
    """

    names: tuple[str, ...] = ()
    patterns: tuple[re.Pattern[str], ...] = ()
    exclude: re.Pattern[str] | None = None
    is_all: bool = False
    node: str = ""
    with_hidden: bool = True

    @property
    def is_searching(self) -> bool:
        """Whether topics that appear later are recorded."""
        return self.is_all or bool(self.patterns) or bool(self.node)

    def includes(self, topic: str, subscribers: Sequence[str]) -> bool:
        """Return whether to record a topic."""
        if self.exclude is not None and self.exclude.search(topic):
            return False
        return (
            (self.is_all and (self.with_hidden or "/_" not in topic))
            or topic in self.names
            or (bool(self.node) and self.node in subscribers)
            or any(pattern.fullmatch(topic) for pattern in self.patterns)
        )


class RecordLimits(Struct, frozen=True):
    """The limits of a recording; None means no limit.

    With `is_splitting`, a new file starts at `size_bytes` or `duration_s`, and only the last `max_splits`
    files are kept; without it, the recording ends there.
    """

    size_bytes: int | None = None
    duration_s: float | None = None
    is_splitting: bool = False
    max_splits: int | None = None
    messages_per_topic: int | None = None


class RecordingProgress(Struct):
    """The progress of a recording, over all files.

    `finished_bytes` is the size of the closed files, and `counts` has the number of messages by topic.
    """

    message_count: int = 0
    finished_bytes: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)
