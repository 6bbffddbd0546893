"""Publishes recordings on a graph at their recorded times, or faster or slower, with pauses and steps.

Recorded time advances with the wall clock times the rate, but not while paused. Due messages are sent
together, in one batch per topic.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import islice

from msgspec import Struct, field

from rostether.errors import RecordingError
from rostether.graph.ports import Graph, Publisher
from rostether.graph.ros_clock import CLOCK_TOPIC, CLOCK_TYPE, encode_clock
from rostether.graph.static_transforms import StaticTransforms
from rostether.msgdef.interface import ANY_MESSAGE, MessageType
from rostether.recording.recorded import Connection, RecordedMessage, RecordingReader, merged
from rostether.rostime import NS_PER_S, Time

# How long a slow subscriber may delay the others; then it loses its oldest messages.
DRAIN_S = 0.5

# Messages sent before other tasks run: about 2 ms of reading.
BATCH_MESSAGES = 500

# Bytes sent before other tasks run: fewer than fit in a subscriber's queue. So large messages that are due
# together, such as images with `--immediate`, do not push each other out of it.
BATCH_BYTES = 1 << 20

# The time to wait at the end for slow subscribers: enough for 50 MB on a busy machine.
END_DRAIN_S = 5.0

# The number of messages read to estimate their size, if the queue length is given in messages.
SAMPLE_MESSAGES = 2000

# The largest queue, even if more is requested.
MAX_QUEUE_BYTES = 1 << 30

# The memory of a queued message besides its payload, at most.
QUEUED_BYTES = 64

# The maximum delay before a key takes effect.
LONGEST_SLEEP_S = 0.05

# The md5sum of tf2_msgs/TFMessage and tf/tfMessage, which have the same fields in ROS 1.
_TRANSFORMS_MD5SUM = "94810edda583a504dfda3829e70d7eec"


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


class Player:
    """One playback; `toggle_pause` and `step` may be called while `play` runs.

    Raises RecordingError if the recordings have no messages.
    """

    def __init__(self, graph: Graph, readers: Sequence[RecordingReader], settings: PlaySettings) -> None:
        self.played_count = 0
        self.is_paused = settings.starts_paused
        self._graph = graph
        self._readers = readers
        self._settings = settings
        self._publishers: dict[str, Publisher] = {}
        # The messages to send next, with their number and size.
        self._waiting: dict[Publisher, list[bytes]] = {}
        self._waiting_count = self._waiting_bytes = 0
        # A latched topic keeps the last message of this node, which played several recorded publishers.
        self._static_transforms: dict[str, StaticTransforms] = {}
        self._clock: Publisher | None = None
        self._steps = 0
        # Whether playback waits for a message on the topic that controls the rate.
        self._is_held = False
        self._controlled_s = 0.0
        # The wall clock when the recording was at `_origin_ns`.
        self._origin_s = 0.0
        self._origin_ns = 0
        self._next_clock_s = 0.0
        # The time of the latest message.
        self.time_ns = 0
        spans = [span for reader in readers if (span := reader.span_ns) is not None]
        if not spans:
            raise RecordingError("the recording has no messages")
        first_ns = min(start for start, _ in spans)
        self.start_ns = first_ns + round(settings.start_s * NS_PER_S)
        self.end_ns = max(end for _, end in spans)
        self.length_s = (self.end_ns - first_ns) / NS_PER_S
        if settings.duration_s is not None:
            self.end_ns = min(self.end_ns, self.start_ns + round(settings.duration_s * NS_PER_S))

    def toggle_pause(self) -> None:
        """Pause or resume."""
        self._set_origin(self._now_ns())
        self.is_paused = not self.is_paused

    def step(self) -> None:
        """Play one message, if paused."""
        if self.is_paused:
            self._steps += 1

    async def play(self, on_started: Callable[[], None] | None = None) -> None:
        """Advertise, call `on_started`, and play to the end. Raises RecordingError, GraphError."""
        await self._advertise()
        if on_started is not None:
            on_started()
        if 0 < self._settings.start_s <= self.length_s:
            await self._publish_latched()
        while True:
            before = self.played_count
            await self._play_once()
            if not self._settings.is_looping or self.played_count == before:
                break
        for publisher in self._publishers.values():
            await publisher.drained(END_DRAIN_S)

    async def keep_clock(self) -> None:
        """Publish the clock until canceled."""
        while True:
            self._tick_clock()
            await asyncio.sleep(LONGEST_SLEEP_S)

    async def _advertise(self) -> None:
        kinds: dict[str, tuple[MessageType, bool]] = {}
        for reader in self._readers:
            for connection in reader.counts:
                if self._wants(connection):
                    topic = self._settings.topic_of(connection)
                    is_latching = kinds.get(topic, (None, False))[1] or connection.is_latching
                    kinds[topic] = (connection.type, is_latching)
        sizes = self._sizes(kinds) if self._settings.queue_messages is not None else {}
        for topic, (message_type, is_latching) in kinds.items():
            queue_bytes = min(sizes[topic], MAX_QUEUE_BYTES) if sizes else None
            self._publishers[topic] = await self._graph.advertise(
                topic, message_type, latch=is_latching, queue_bytes=queue_bytes
            )
            if is_latching and message_type.md5sum == _TRANSFORMS_MD5SUM:
                self._static_transforms[topic] = StaticTransforms()
        if self._settings.clock_hz is not None:
            self._clock = await self._graph.advertise(CLOCK_TOPIC, CLOCK_TYPE)
        if control := self._settings.rate_control_topic:
            self._controlled_s = asyncio.get_running_loop().time()
            await self._graph.subscribe(control, ANY_MESSAGE, self._handle_control)
        await asyncio.sleep(self._settings.delay_s)
        if self._settings.waits_for_subscribers:
            # The port does not report connections; polling is cheap.
            while not all(each.subscriber_count for each in self._publishers.values()):  # noqa: ASYNC110
                await asyncio.sleep(0.02)

    def _sizes(self, topics: Collection[str]) -> dict[str, int]:
        """Return the queue size of each topic, estimated from its first messages."""
        sizes = dict.fromkeys(topics, 0)
        for reader in self._readers:
            for message in islice(reader.messages(self._wants, start_ns=self.start_ns), SAMPLE_MESSAGES):
                topic = self._settings.topic_of(message.connection)
                sizes[topic] = max(sizes[topic], len(message.payload) + QUEUED_BYTES)
        largest = max(sizes.values(), default=QUEUED_BYTES) or QUEUED_BYTES
        # As everywhere in ROS, 0 means unlimited.
        count = self._settings.queue_messages or MAX_QUEUE_BYTES
        return {topic: (size or largest) * count for topic, size in sizes.items()}

    def _wants(self, connection: Connection) -> bool:
        return not self._settings.topics or connection.topic in self._settings.topics

    async def _publish_latched(self) -> None:
        """Publish the last message before the start of each latched publisher, such as a map."""
        self.time_ns = self.start_ns
        self._set_origin(self.start_ns)
        latest: dict[tuple[str, str], RecordedMessage] = {}
        end_ns = self.start_ns - 1
        found = merged(self._readers, lambda each: each.is_latching and self._wants(each), end_ns=end_ns)
        for number, message in enumerate(found):
            latest[message.connection.topic, message.connection.caller_id] = message
            # Recordings of ROS 2 do not name the publisher.
            if transforms := self._static_transforms.get(self._settings.topic_of(message.connection)):
                transforms.merge(message.payload)
            if not number % BATCH_MESSAGES:
                await asyncio.sleep(0)
        for message in sorted(latest.values(), key=lambda each: each.time_ns):
            self._queue(message)
        await self._send()

    def _queue(self, message: RecordedMessage) -> None:
        topic, payload = self._settings.topic_of(message.connection), message.payload
        if transforms := self._static_transforms.get(topic):
            payload = transforms.merge(payload)
        self._waiting.setdefault(self._publishers[topic], []).append(payload)
        self._waiting_count += 1
        self._waiting_bytes += len(payload)

    async def _play_once(self) -> None:
        self._set_origin(self.start_ns)
        last_ns = self.start_ns
        for message in merged(self._readers, self._wants, start_ns=self.start_ns, end_ns=self.end_ns):
            gap_s = (message.time_ns - last_ns) / NS_PER_S
            last_ns = message.time_ns
            skip = self._settings.skip_empty_s
            if skip is not None and gap_s > skip:
                self._set_origin(message.time_ns)
            if not self._is_due(message.time_ns):
                await self._send()
                await self._until(message.time_ns)
            self.time_ns = message.time_ns
            if message.connection.topic in self._settings.pause_topics and not self.is_paused:
                self.toggle_pause()
            self._queue(message)
            if self._waiting_count >= BATCH_MESSAGES or self._waiting_bytes >= BATCH_BYTES:
                await self._send()
                await asyncio.sleep(0)
        await self._send()

    def _handle_control(self, payloads: Sequence[bytes]) -> None:
        self._controlled_s = asyncio.get_running_loop().time()

    def _is_due(self, time_ns: int) -> bool:
        if self._settings.rate_control_topic:
            silence_s = asyncio.get_running_loop().time() - self._controlled_s
            is_held = silence_s > self._settings.rate_control_max_delay_s
            if is_held != self._is_held:
                self._set_origin(self._now_ns())
                self._is_held = is_held
        if self.is_paused or self._is_held:
            return False
        return self._settings.is_immediate or self._now_ns() >= time_ns

    async def _until(self, time_ns: int) -> None:
        while not self._is_due(time_ns):
            if self.is_paused and self._steps:
                self._steps -= 1
                self._origin_ns = time_ns
                return
            self._tick_clock()
            wait_s = LONGEST_SLEEP_S
            if not self.is_paused and not self._is_held:
                wait_s = min(wait_s, (time_ns - self._now_ns()) / NS_PER_S / self._settings.rate)
            if self._settings.clock_hz is not None:
                wait_s = min(wait_s, 1 / self._settings.clock_hz)
            await asyncio.sleep(max(wait_s, 0))

    async def _send(self) -> None:
        self._tick_clock()
        waiting, self._waiting = self._waiting, {}
        self._waiting_count = self._waiting_bytes = 0
        for publisher, payloads in waiting.items():
            self.played_count += len(payloads)
            if not publisher.publish_raw(payloads):
                await publisher.drained(DRAIN_S)

    def _now_ns(self) -> int:
        if self.is_paused or self._is_held:
            return self._origin_ns
        passed_s = asyncio.get_running_loop().time() - self._origin_s
        return self._origin_ns + round(passed_s * self._settings.rate * NS_PER_S)

    def _set_origin(self, time_ns: int) -> None:
        self._origin_ns = time_ns
        self._origin_s = asyncio.get_running_loop().time()

    def _tick_clock(self) -> None:
        if self._clock is None or self._settings.clock_hz is None:
            return
        now_s = asyncio.get_running_loop().time()
        if now_s >= self._next_clock_s:
            self._next_clock_s = now_s + 1 / self._settings.clock_hz
            time_ns = self.time_ns if self._settings.is_immediate else self._now_ns()
            self._clock.publish_raw([encode_clock(Time.from_ns(time_ns))])
