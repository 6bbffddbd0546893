"""One connection to a board: converts bytes to events for endpoints and graph, and messages to bytes.

    transport ── data_received ──> HostLink ── events ──> endpoints ──> graph
    transport <── Outbox.flush <── HostLink, endpoints <── graph

All messages of a topic in a chunk are passed on in one call: nothing here runs for each message.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Any

from rostether.bridge.board_node import BoardNode
from rostether.bridge.findings.line_watch import NO_ANSWER_S
from rostether.bridge.findings.medium import Medium
from rostether.bridge.outbound.held_events import HeldEvents
from rostether.bridge.outbound.outbox import Outbox
from rostether.bridge.outbound.reading_pause import ReadingPause
from rostether.bridge.outbound.stamps import Stamps
from rostether.bridge.outbound.topic_queue import TopicQueue
from rostether.bridge.parameter_relay import ParameterRelay
from rostether.errors import TransportError
from rostether.graph.ports import Level
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import (
    AnnouncementRefused,
    ControlFlood,
    DeviceReset,
    DeviceSilent,
    HostEvent,
    LogReceived,
    MessagesReceived,
    NegotiationSettled,
    ParameterRequested,
    ProtocolDetected,
    ServiceAnnounced,
    ServiceWithdrawn,
    TimeRequested,
    TopicAnnounced,
    TopicRole,
    TopicWithdrawn,
    UnknownTopicId,
)
from rostether.rosserial.host_link import HostLink
from rostether.transports.transport import Transport

# Nested searches for frames inside messages. Noise within noise passes its checksum once in 65,536 times. A
# board that sends only noise makes the scanner read each byte that many more times.
MAX_RESCAN_DEPTH = 2

_FLOODED = {ids.LOG: "log lines", ids.TIME: "time requests", ids.PARAMETER: "parameter requests"}

_LOG = logging.getLogger(__name__)


class Session:
    """One connection of one board, from `start` until the transport ends or `stop`.

    It is the transport's receiver, and its endpoints' `BoardLine`. `baud` is the baud rate of a serial line.
    """

    def __init__(self, transport: Transport, node: BoardNode, *, baud: int | None = None) -> None:
        self.node = node
        self.transport = transport

        # The baud rate of the line; None for a network or a pseudo-terminal, which have flow control.
        self.baud = None if transport.can_pause else baud
        self.link = HostLink(node.link_config())
        self.receivers: dict[int, Callable[[list[bytes]], None]] = {}
        self._loop = asyncio.get_running_loop()
        self.received_at_s = self._loop.time()
        self._notices = node.notices
        self.outbox = Outbox(
            transport,
            self.link,
            self._loop,
            on_dropped=self._report_dropped,
            settings=node.settings,
            baud=self.baud,
        )
        self._parameters = ParameterRelay(
            self.link, node.graph, node.notices, node.settings, self.outbox.flush, node.device.access
        )
        network = Medium.TCP if transport.can_pause else Medium.UDP
        medium = Medium.SERIAL if transport.remote is None else network
        self.watch = node.health.connected(baud, self.link.statistics, self.received_at_s, medium)
        self._stamps = Stamps(node.health.clock, node.graph.now)
        self._no_answer: asyncio.TimerHandle | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due_s = 0.0
        self._pause = ReadingPause(transport, node.notices.report_defect)
        self._setup = node.setup
        self._setup.connected()
        self._was_reset = False
        self._rescan_depth = 0
        self._held = HeldEvents(node.store.registry, self._act, self._fail)
        self._ended: asyncio.Future[TransportError | None] = self._loop.create_future()
        self._handlers: dict[type[Any], Callable[[Any], None]] = {
            TopicAnnounced: self._topic_announced,
            TopicWithdrawn: node.endpoints.withdraw,
            ServiceAnnounced: self._service_announced,
            ServiceWithdrawn: node.endpoints.withdraw,
            MessagesReceived: lambda event: self._deliver(event.topic_id, event.payloads),
            AnnouncementRefused: self._setup.report_refusal,
            NegotiationSettled: self._settled,
            TimeRequested: self._time_requested,
            LogReceived: lambda event: node.notices.report(Level[event.level.name], event.text),
            ParameterRequested: lambda event: self._parameters.ask(event.name),
            UnknownTopicId: self._unknown_id,
            ControlFlood: self._control_flood,
            DeviceReset: self._device_reset,
            DeviceSilent: self._report,
            ProtocolDetected: self._report,
        }

    def __repr__(self) -> str:
        return f"<session of {self.node.graph.node_name} on {self.transport.peer}>"

    @property
    def is_connected(self) -> bool:
        """Whether the transport is still open."""
        return not self._ended.done()

    @property
    def is_searching(self) -> bool:
        """Whether announcements wait until their types are found on disk."""
        return self._held.is_waiting

    def start(self) -> None:
        """Request the board's topics, and start to relay messages."""
        _LOG.debug("%r: started", self)
        self.link.start(self._loop.time())
        self.transport.start(self)
        self._no_answer = self._loop.call_later(NO_ANSWER_S, self._check_answer)
        self._after_link()

    async def wait_ended(self) -> TransportError | None:
        """Wait until the connection ends; return the error, None if the bridge ended it."""
        return await asyncio.shield(self._ended)

    async def stop(self) -> None:
        """Ask the board to stop sending, then close the connection."""
        if self.is_connected:
            self.link.stop()
            self.outbox.flush()
        self.transport.close()
        await self.transport.wait_closed()
        self._end(None)

    def abandon(self) -> None:
        """End without a report: the board has another connection now."""
        self.transport.close()
        self._end(None)

    def data_received(self, data: bytes) -> None:
        """Handle a chunk from the transport."""
        if self._ended.done():
            return
        now_s = self.received_at_s = self._loop.time()
        try:
            events = self.link.receive_data(data, now_s)
            is_quiet = self.link.is_quiet
            for event in events:
                self._handle(event)
            if not is_quiet:
                self._after_link()
        except Exception as error:  # noqa: BLE001 - an error caused by one board ends only its session
            self._fail(error)

    def connection_lost(self, error: TransportError | None) -> None:
        """Handle the end of the transport."""
        self._end(error)

    def pause_writing(self) -> None:
        """Stop writing: the transport is full."""
        self.outbox.pause_writing()

    def resume_writing(self) -> None:
        """Write again: the transport accepts more."""
        if not self._ended.done():
            self.outbox.resume_writing()

    def pause_until(self, wait: Callable[[], Awaitable[object]]) -> bool:
        """Read nothing from the board until `wait()` ends; return False if the line cannot pause."""
        return not self._ended.done() and self._pause.pause_until(wait)

    def rescan(self, payload: bytes) -> None:
        """Handle the frames inside a message that does not have its type's layout.

        Noise that looks like a header can hide the frames after it in a false message.
        """
        if self._rescan_depth < MAX_RESCAN_DEPTH:
            self._rescan_depth += 1
            try:
                for event in self.link.rescan(payload, self._loop.time()):
                    self._handle(event)
            finally:
                self._rescan_depth -= 1
        self._after_link()

    def call_started(self) -> None:
        """Record that the board waits for a response."""
        self.link.service_call_started()

    def call_finished(self) -> None:
        """Record that the response was sent or canceled."""
        self.link.service_call_finished(self._loop.time())
        self._after_link()

    def _after_link(self) -> None:
        self.outbox.flush()
        due_s = self.link.get_timer()
        if due_s is None:
            return
        # A timer that fires too early costs one check; setting it again for each chunk would cost more.
        if self._timer is None or due_s < self._timer_due_s:
            if self._timer is not None:
                self._timer.cancel()
            self._timer_due_s = due_s
            self._timer = self._loop.call_at(due_s, self._handle_timer)

    def _handle_timer(self) -> None:
        self._timer = None
        try:
            for event in self.link.handle_timer(self._loop.time()):
                self._handle(event)
            self._after_link()
        except Exception as error:  # noqa: BLE001 - as in data_received
            self._fail(error)

    def _deliver(self, topic_id: int, payloads: list[bytes]) -> None:
        receive = self.receivers.get(topic_id)
        if receive is not None:
            receive(payloads)
        else:
            self._held.keep(MessagesReceived(topic_id, payloads))
        if topic_id in self._stamps.offsets:
            self._stamps.track(topic_id, payloads, self._loop.time())

    def _handle(self, event: HostEvent) -> None:
        if type(event) is MessagesReceived:
            self._deliver(event.topic_id, event.payloads)
            return
        self.watch.handle_event(event, self._loop.time())
        if not self._held.hold_back(event):
            self._act(event)

    def _act(self, event: HostEvent) -> None:
        handle = self._handlers.get(type(event))
        if handle is not None:
            handle(event)

    def _check_answer(self) -> None:
        if self.link.version is None:
            self._report(None)

    def _topic_announced(self, event: TopicAnnounced) -> None:
        self._setup.note_size(event)
        if self.node.endpoints.announce_topic(event, self):
            self._setup.report_topic(event)
            if event.role is TopicRole.PUBLISHER:
                self._stamps.announced(event.info, self.node.store.registry)

    def _service_announced(self, event: ServiceAnnounced) -> None:
        if self.node.endpoints.announce_service(event, self):
            self._setup.report_service(event)

    def _settled(self, _event: NegotiationSettled) -> None:
        self.node.endpoints.settle()
        self.node.health.required.compare(self.node.endpoints.announced_topics())
        if self._was_reset:
            self._was_reset = False
            self.node.endpoints.renew_latched()

    def _time_requested(self, _event: TimeRequested) -> None:
        now_s = self._loop.time()
        time = self.node.graph.now()
        self.link.answer_time(time, now_s)
        self._stamps.answered(time, now_s)
        self.node.endpoints.time_requested(now_s)

    def _unknown_id(self, event: UnknownTopicId) -> None:
        self._notices.report_episode(
            "unknown id",
            Level.WARN,
            f"messages on topic id {event.topic_id}, which was not announced; requesting the topics again",
            count=event.count,
        )

    def _control_flood(self, event: ControlFlood) -> None:
        what = _FLOODED.get(event.topic_id, "announcements of topics")
        self._notices.report_episode(
            f"flood of {what}",
            Level.WARN,
            f"the board sends too many {what}; the rest is ignored; let loop() in the sketch wait between "
            "them",
            count=event.count,
        )

    def _device_reset(self, _event: DeviceReset) -> None:
        self._was_reset = True
        self.node.health.clock.forget()
        self.node.endpoints.device_reset()
        self._notices.report_episode("reset", Level.INFO, "the board was reset; requesting its topics")

    def note_pause(self) -> None:
        """Record that a simulated board paused with its simulator."""
        self.watch.loop_speed.note_pause()

    def _report(self, _event: object) -> None:
        """Report findings immediately, without waiting for the next check."""
        now_s = self._loop.time()
        self.node.health.report(self.node.health.find(now_s), now_s)

    def _report_dropped(self, queue: TopicQueue, count: int) -> None:
        self._notices.report_episode(
            f"overflow {queue.topic}",
            Level.WARN,
            f"{queue.topic} is faster than the board can receive; dropping its oldest messages",
            count=count,
        )

    def _fail(self, error: Exception) -> None:
        self._notices.report_episode(
            "defect",
            Level.ERROR,
            f"the session failed ({type(error).__name__}: {error}) and starts again; please report it",
        )
        self.transport.close()

    def _end(self, error: TransportError | None) -> None:
        if self._ended.done():
            return
        self._ended.set_result(error)
        _LOG.debug("%r: ended: %s", self, error or "closed by the bridge")
        for timer in (self._timer, self._no_answer):
            if timer is not None:
                timer.cancel()
        self._pause.close()
        self._held.drop()
        self._parameters.close()
        self.outbox.close()
        self.node.endpoints.detach_all()
