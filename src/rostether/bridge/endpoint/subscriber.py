"""A topic that the board subscribes to: the graph's messages that fit in the board's buffer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rostether.bridge.endpoint.board_line import BoardLine
from rostether.bridge.outbound.topic_queue import TopicQueue
from rostether.bridge.reporter import Notices
from rostether.graph.ports import Graph, Level, Subscriber
from rostether.mechanisms.text import counted
from rostether.rosserial.packets import TopicInfo
from rostether.serde.store import TypeStore


class SubscriberEndpoint:
    """One topic id on which the board receives; at most `queue_depth` messages wait (None: any)."""

    def __init__(
        self,
        info: TopicInfo,
        store: TypeStore,
        graph: Graph,
        notices: Notices,
        queue_depth: int | None = None,
    ) -> None:
        self.info = info
        self.message_count = 0
        self.misfit_count = 0
        self.largest_oversize_bytes = 0
        self.has_latched_source = False
        self._type = store.registry.message_type(info.message_type)
        self._layout = store.layout(info.message_type)
        self._accepts_all = self._layout.accepts_all
        self._graph = graph
        self._notices = notices
        self._queue_depth = queue_depth
        self._line: BoardLine | None = None
        self._queue: TopicQueue | None = None
        self._dropped_before = 0
        self._subscriber: Subscriber | None = None

    @property
    def dropped_count(self) -> int:
        """How many messages the board was too slow for."""
        return self._dropped_before + (self._queue.dropped_count if self._queue is not None else 0)

    def attach(self, line: BoardLine, info: TopicInfo) -> None:
        """Send to a connection from now on."""
        self.detach()
        self.info = info
        self._line = line
        self._queue = TopicQueue(info.topic_id, info.topic_name, self._queue_depth)
        self._queue.set_source(self._subscriber)
        size = self._layout.fixed_size_bytes
        if size is not None and size > info.buffer_size:
            self._report_oversize(size)

    def detach(self) -> None:
        """Release the connection; messages that arrive until the next one are dropped."""
        if self._line is not None and self._queue is not None:
            self._line.outbox.remove(self._queue)
            self._dropped_before += self._queue.dropped_count
        self._line = self._queue = None

    def __repr__(self) -> str:
        return f"<subscriber {self.info.topic_name} [{self.info.message_type}] id {self.info.topic_id}>"

    async def open(self) -> None:
        """Subscribe. Raises GraphError, InvalidNameError."""
        subscriber = await self._graph.subscribe(
            self.info.topic_name, self._type, self.deliver, on_connection=self._note_latching
        )
        self._subscriber = subscriber
        if self._queue is not None:
            self._queue.set_source(subscriber)

    async def close(self) -> None:
        """Unsubscribe."""
        subscriber, self._subscriber = self._subscriber, None
        if self._queue is not None:
            self._queue.set_source(None)
        if subscriber is not None:
            await subscriber.close()

    async def renew(self) -> None:
        """Subscribe again, so that a board that has lost its state receives latched messages again."""
        await self.close()
        await self.open()

    def deliver(self, payloads: Sequence[bytes]) -> None:
        """Handle messages from the graph."""
        line, queue = self._line, self._queue
        if line is None or queue is None:
            return
        # This check comes first, because checking the layout of many MB would block all boards.
        if payloads and max(map(len, payloads)) > self.info.buffer_size:
            payloads = self._drop_oversize(payloads)
        if not self._accepts_all(payloads):
            payloads = self._drop_misfits(payloads)
        if payloads:
            self.message_count += len(payloads)
            line.outbox.put(queue, payloads)

    def _note_latching(self, header: Mapping[str, str]) -> None:
        if header.get("latching") == "1":
            self.has_latched_source = True

    def _drop_misfits(self, payloads: Sequence[bytes]) -> list[bytes]:
        accepts = self._layout.accepts
        fitting = [payload for payload in payloads if accepts(payload)]
        self.misfit_count += len(payloads) - len(fitting)
        first = next(payload for payload in payloads if not accepts(payload))
        self._notices.report_episode(
            f"misfit to {self.info.topic_name}",
            Level.WARN,
            lambda: f"dropped a malformed message of {self.info.topic_name}: {self._layout.explain(first)}",
            count=len(payloads) - len(fitting),
        )
        return fitting

    def _drop_oversize(self, payloads: Sequence[bytes]) -> list[bytes]:
        limit = self.info.buffer_size
        fitting = [payload for payload in payloads if len(payload) <= limit]
        self._report_oversize(max(map(len, payloads)), len(payloads) - len(fitting))
        return fitting

    def _report_oversize(self, size: int, count: int = 0) -> None:
        self.largest_oversize_bytes = max(self.largest_oversize_bytes, size)
        self._notices.report_episode(
            f"oversize {self.info.topic_name}",
            Level.ERROR,
            f"not sent: a message of {self.info.topic_name} [{self._type.name}] has "
            f"{counted(size, 'byte')}, but the board's buffer has only {self.info.buffer_size}; enlarge "
            "it in the sketch, or send smaller messages",
            count=count,
        )
