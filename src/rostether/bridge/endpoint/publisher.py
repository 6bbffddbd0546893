"""A topic that the board publishes: checked against its type's layout, then published unchanged."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from struct import Struct

from rostether.bridge.endpoint.board_line import BoardLine, stop_receiving
from rostether.bridge.outbound.stamps import has_header
from rostether.bridge.reporter import Notices
from rostether.bridge.settings import BridgeSettings
from rostether.errors import DefinitionError, InvalidNameError, TypeMismatchError
from rostether.graph.ports import Graph, Level, Publisher
from rostether.graph.static_transforms import STATIC_TOPIC, TRANSFORM_TYPES, StaticTransforms
from rostether.mechanisms.tasks import occurs_within
from rostether.rosserial.frame import SYNC
from rostether.rosserial.packets import TopicInfo
from rostether.serde.store import TypeStore

# Messages kept until the topic is advertised: a master answers in milliseconds, a flood fills this in 20 ms.
HELD_BYTES = 256 * 1024
# The overhead of each held message, besides its payload.
MESSAGE_OVERHEAD_BYTES = 64
_SYNC = bytes((SYNC,))
# Header.seq, the first field of a message that begins with a Header.
_SEQUENCE = Struct("<I")
_SEQUENCES = 1 << 32
# How long a flood pauses the board, once, before the oldest messages are dropped: other topics pause too.
SETUP_PAUSE_S = 1.0


class PublisherEndpoint:
    """One topic id on which the board sends; `admit` returns how many of a number of messages may pass."""

    def __init__(
        self,
        info: TopicInfo,
        store: TypeStore,
        graph: Graph,
        notices: Notices,
        settings: BridgeSettings,
        admit: Callable[[int], int] | None = None,
    ) -> None:
        self.info = info
        self.message_count = 0
        self.misfit_count = 0
        self.dropped_count = 0
        self._type = store.registry.message_type(info.message_type)
        self._layout = store.layout(info.message_type)
        self._accepts_all = self._layout.accepts_all
        self._graph = graph
        self._notices = notices
        self._settings = settings
        self._admit = admit
        self._has_header = has_header(store.registry, info.message_type)
        # As every static broadcaster, the board latches its transforms: in ROS 2, tf2 requires it.
        is_static = self._type.name in TRANSFORM_TYPES and graph.resolve(info.topic_name).endswith(
            STATIC_TOPIC
        )
        self._static_transforms = StaticTransforms() if is_static else None
        self._sequence = 0
        self._line: BoardLine | None = None
        self._publisher: Publisher | None = None
        # Whether the graph has accepted or refused the topic.
        self._is_decided = asyncio.Event()
        self._held: list[bytes] = []
        self._held_bytes = 0
        self._has_paused = False

    @property
    def lost_count(self) -> int:
        """How many messages slow subscribers have lost; the graph reports which subscribers."""
        return self._publisher.dropped_count if self._publisher is not None else 0

    @property
    def has_subscribers(self) -> bool:
        """Whether the topic is advertised and a subscriber is connected."""
        return self._publisher is not None and self._publisher.subscriber_count > 0

    def attach(self, line: BoardLine, info: TopicInfo) -> None:
        """Handle the messages of a connection."""
        self.detach()
        self.info = info
        self._line = line
        line.receivers[info.topic_id] = self.receive

    def detach(self) -> None:
        """Release the connection."""
        if self._line is not None:
            stop_receiving(self._line, self.info.topic_id, self.receive)
            self._line = None

    def __repr__(self) -> str:
        return f"<publisher {self.info.topic_name} [{self.info.message_type}] id {self.info.topic_id}>"

    async def open(self) -> None:
        """Advertise, then publish the kept messages. Raises GraphError, DefinitionError, InvalidNameError."""
        self._is_decided.clear()
        try:
            publisher = await self._graph.advertise(
                self.info.topic_name,
                self._type,
                latch=self._static_transforms is not None,
                queue_bytes=self._settings.subscriber_bytes,
            )
        except (DefinitionError, InvalidNameError, TypeMismatchError):
            self._is_decided.set()
            raise
        held, self._held, self._held_bytes = self._held, [], 0
        self._publisher = publisher
        self._is_decided.set()
        if held:
            self._publish(publisher, held)

    async def close(self) -> None:
        """Unadvertise."""
        if self._publisher is not None:
            await self._publisher.close()

    def receive(self, payloads: list[bytes]) -> None:
        """Handle messages from the board."""
        if self._accepts_all(payloads):
            self._publish_or_hold(payloads)
        else:
            self._sort_out(payloads)

    def _publish_or_hold(self, payloads: list[bytes]) -> None:
        if self._admit is not None:
            payloads = self._keep_rate(payloads, self._admit(len(payloads)))
        if not payloads:
            return
        self.message_count += len(payloads)
        if self._publisher is None:
            self._hold(payloads)
        else:
            self._publish(self._publisher, payloads)

    def _publish(self, publisher: Publisher, payloads: list[bytes]) -> None:
        if self._has_header:
            payloads = self._count(payloads)
        elif self._static_transforms is not None:
            payloads = [self._static_transforms.merge(each) for each in payloads]
        if not publisher.publish_raw(payloads) and self._line is not None:
            self._line.pause_until(partial(self._pause, publisher))

    async def _pause(self, publisher: Publisher) -> None:
        while not publisher.publish_raw([]):
            await publisher.drained(self._settings.drain_pause_s)

    def _count(self, payloads: list[bytes]) -> list[bytes]:
        """Return the messages with the topic's own count as Header.seq, as in rospy and roscpp."""
        first = self._sequence + 1
        self._sequence = (self._sequence + len(payloads)) % _SEQUENCES
        pack, size = _SEQUENCE.pack, _SEQUENCE.size
        if self._sequence < first:
            return [
                pack(number % _SEQUENCES) + payload[size:] for number, payload in enumerate(payloads, first)
            ]
        return [pack(number) + payload[size:] for number, payload in enumerate(payloads, first)]

    def _keep_rate(self, payloads: list[bytes], admitted: int) -> list[bytes]:
        dropped = len(payloads) - admitted
        if dropped:
            self.dropped_count += dropped
            self._notices.report_episode(
                "messages_hz",
                Level.WARN,
                f"the board sends more than {self._settings.messages_hz:g} messages a second (its limit "
                "messages_hz), and the rest is dropped; publish less often, or raise the limit",
                count=dropped,
            )
        return payloads[:admitted]

    def _sort_out(self, payloads: list[bytes]) -> None:
        """Accept valid messages, and search invalid ones for frames inside, in the order of arrival."""
        accepts = self._layout.accepts
        line = self._line
        fitting: list[bytes] = []
        misfits: list[bytes] = []
        for payload in payloads:
            if accepts(payload):
                fitting.append(payload)
                continue
            misfits.append(payload)
            if line is not None and _SYNC in payload:
                self._publish_or_hold(fitting)
                fitting = []
                line.rescan(payload)
        self._publish_or_hold(fitting)
        first = misfits[0]
        self.misfit_count += len(misfits)
        self._notices.report_episode(
            f"misfit {self.info.topic_name}",
            Level.WARN,
            lambda: (
                f"dropped a message of {self.info.topic_name} that is damaged or has another definition: "
                f"{self._layout.explain(first)}"
            ),
            count=len(misfits),
        )

    def _hold(self, payloads: list[bytes]) -> None:
        self._held += payloads
        self._held_bytes += sum(map(len, payloads)) + MESSAGE_OVERHEAD_BYTES * len(payloads)
        if self._held_bytes <= HELD_BYTES:
            return
        line = None if self._has_paused or self._is_decided.is_set() else self._line
        if line is None or not line.pause_until(self._wait_decided):
            self._drop_held()

    async def _wait_decided(self) -> None:
        if not await occurs_within(self._is_decided, SETUP_PAUSE_S):
            self._has_paused = True
            self._drop_held()

    def _drop_held(self) -> None:
        dropped = 0
        while self._held_bytes > HELD_BYTES:
            self._held_bytes -= len(self._held[dropped]) + MESSAGE_OVERHEAD_BYTES
            dropped += 1
        del self._held[:dropped]
        self.dropped_count += dropped
        # The refusal of a topic is already reported.
        if self._is_decided.is_set():
            return
        self._notices.report_episode(
            f"held {self.info.topic_name}",
            Level.WARN,
            f"{self.info.topic_name} is not advertised yet: its oldest messages are lost",
            count=dropped,
        )
