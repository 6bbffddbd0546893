"""How to play recordings."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct, field

from rostether.recording.recorded import Connection


class PlaySettings(Struct, frozen=True):
    """How to play; `start_s`, `duration_s` and `skip_empty_s` are recorded time, other times are real time.

    Without `duration_s`, the recording is played to its end; without `topics`, all topics are played. Gaps
    longer than `skip_empty_s` are skipped. Playback begins `delay_s` after the topics are advertised, and
    pauses at each message on `pause_topics`. With `rate_control_topic`, it waits whenever no message has
    arrived there for `rate_control_max_delay_s`. `queue_messages` limits the queue of each subscriber; 0
    means unlimited.
    """

    rate: float = 1.0
    start_s: float = 0.0
    duration_s: float | None = None
    is_immediate: bool = False
    is_looping: bool = False
    starts_paused: bool = False
    skip_empty_s: float | None = None
    delay_s: float = 0.2
    clock_hz: float | None = None
    queue_messages: int | None = None
    waits_for_subscribers: bool = False
    pause_topics: frozenset[str] = frozenset()
    rate_control_topic: str = ""
    rate_control_max_delay_s: float = 1.0
    topics: frozenset[str] = frozenset()
    prefix: str = ""
    remappings: Mapping[str, str] = field(default_factory=dict)

    def topic_of(self, connection: Connection) -> str:
        """Return the name under which a recorded topic is played."""
        name = self.remappings.get(connection.topic, connection.topic)
        return f"{self.prefix.rstrip('/')}/{name.lstrip('/')}" if self.prefix else name
