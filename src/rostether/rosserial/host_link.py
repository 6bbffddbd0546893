"""The host's end of a rosserial line: received bytes become events, and requests become bytes to send.

The link combines these state machines, and has no other states:

    ProtocolDetector, FrameDecoder   bytes to frames
    Negotiation                      when to request topics, when all are known
    Presence                         whether the device is connected and configured
    TopicTable, Announcements        its endpoints, and those that cannot be bridged
    ControlRate                      how many control frames it may send
    HostOutput                       frames to send, and frames that must wait

Frames that are larger than a device's buffer, or whose id it has not announced since its last reset, can
crash the device. They are not sent.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

from msgspec import Struct

from rostether.rosserial import topic_id as ids
from rostether.rosserial.announcements import Announcements
from rostether.rosserial.control_rate import ControlRate
from rostether.rosserial.events import (
    DAMAGE,
    ControlFlood,
    DeviceReset,
    DeviceSilent,
    DiscardReason,
    FrameDiscarded,
    HostEvent,
    LogReceived,
    MessagesReceived,
    NegotiationSettled,
    ParameterRequested,
    ProtocolDetected,
    TimeRequested,
    UnknownTopicId,
)
from rostether.rosserial.frame import MAX_PAYLOAD_BYTES
from rostether.rosserial.frame_decoder import Decoded, FrameDecoder, Frames
from rostether.rosserial.host_output import HostOutput
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.rosserial.negotiation import Negotiation
from rostether.rosserial.packets import (
    TIME_REQUEST_BYTES,
    Log,
    ParameterRequest,
    ParameterResponse,
    TopicInfo,
)
from rostether.rosserial.presence import Presence, Verdict
from rostether.rosserial.protocol_detector import ProtocolDetector
from rostether.rosserial.topic_answers import TimeRequestMeaning
from rostether.rosserial.topic_table import TopicTable
from rostether.rosserial.unread_bytes import UnreadBytes
from rostether.rostime import Time

_LOG = logging.getLogger(__name__)


class HostLinkConfig(Struct, frozen=True):
    """Limits of a host link; the defaults suit all known boards."""

    # The maximum of a frame: Linux devices send images in one frame.
    max_payload_bytes: int = MAX_PAYLOAD_BYTES
    # The established library has at most 50; each costs a registration on the ROS side.
    max_endpoints: int = 256
    # Returns the size of every message of a topic if its type has a fixed size, else None.
    fixed_size: Callable[[TopicInfo], int | None] | None = None
    # The device's name in the log.
    name: str = "a board"


class HostLink:
    """The host's link to one device: bytes, messages and `now_s` go in, events and bytes come out.

    `now_s` is the time of any monotonic clock.
    After every call that may have changed something, send `data_to_send()` and wait for `get_timer()`. After
    a `receive_data` that was quiet, this is not necessary, which halves the cost of boards that send one
    message at a time.
    """

    def __init__(self, config: HostLinkConfig | None = None) -> None:
        self.statistics = LinkStatistics()
        self._config = config or HostLinkConfig()
        self._version: int | None = None
        self._table = TopicTable(self._config.max_endpoints, self._config.fixed_size)
        # The bytes that the device has not read yet; the driver sends only messages that have room there.
        self.unread = UnreadBytes()
        self._output = HostOutput(self._table, self.statistics, self.unread)
        self._limits = self._table.limits
        self._line: ProtocolDetector | FrameDecoder = self._listen()
        self._negotiation = Negotiation(self._config.name, self.unread)
        self._presence = Presence(self._config.name)
        self._rate = ControlRate()
        self._announcements = Announcements(self._table, self._rate)
        self._is_stopped = False
        # Whether the last `receive_data` brought only messages: no bytes to send, and no earlier timer.
        self.is_quiet = False

    @property
    def version(self) -> int | None:
        """The protocol version of the device, None until known."""
        return self._version

    @property
    def is_settled(self) -> bool:
        """Whether the set of endpoints is considered complete."""
        return self._negotiation.is_settled

    def start(self, now_s: float) -> None:
        """Begin: the first topic request is ready to be sent."""
        self._negotiation.ask(now_s)
        self._pump(now_s)

    def receive_data(self, data: bytes | bytearray | memoryview, now_s: float) -> list[HostEvent]:
        """Process a chunk from the device, which may end anywhere. Never raises because of its data.

        Announcements and other control packets of a chunk are reported before its messages.
        """
        if self._is_stopped:
            return []
        self.statistics.bytes_received += len(data)
        line = self._line
        decoded = line.feed(data, now_s)
        if type(line) is FrameDecoder and len(decoded) == 1 and not line.pending_bytes:
            frames = decoded[0]
            if (
                type(frames) is Frames
                and frames.topic_id in self._table.senders
                and self._presence.is_certain
            ):
                self.is_quiet = True
                return [self._receive_messages(frames, now_s)]
        self.is_quiet = False
        events = self._handle_decoded(decoded, now_s)
        self._pump(now_s)
        return events

    def rescan(self, payload: bytes, now_s: float) -> list[HostEvent]:
        """Return the events of the frames inside a message that does not have its type's layout."""
        if isinstance(self._line, ProtocolDetector) or self._is_stopped:
            return []
        events = self._handle_decoded(self._line.rescan(payload, now_s), now_s)
        self._pump(now_s)
        return events

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, on the clock of `now_s`; None if nothing is scheduled."""
        if self._is_stopped:
            return None
        timers = (
            self._line.get_timer(),
            self._negotiation.get_timer(),
            self._presence.get_timer(probes=self.is_settled),
            self._output.get_timer(),
            self.unread.get_timer(),
        )
        return min((timer for timer in timers if timer is not None), default=None)

    def handle_timer(self, now_s: float) -> list[HostEvent]:
        """Do all work that is due by `now_s`; an early call has no effect."""
        if self._is_stopped:
            return []
        events = self._handle_decoded(self._line.handle_timer(now_s), now_s)
        self.unread.handle_timer(now_s)
        is_flowing = self._line.is_receiving(ids.ANNOUNCEMENTS, now_s)
        if self._negotiation.handle_timer(now_s, is_flowing=is_flowing):
            self._settle(now_s, events)
        self._judge(self._presence.handle_timer(now_s, probes=self.is_settled), now_s, events)
        self._pump(now_s)
        return events

    def data_to_send(self) -> bytes:
        """Return the waiting control frames, and remove them from the queue."""
        return self._output.pop_ready()

    def encode_message(self, topic_id: int, payload: bytes) -> bytes:
        """Return the frame to send.

        Raises LocalProtocolError if the device has not announced a subscriber with this id since its last
        reset, or if the payload does not fit in the device's buffer.
        """
        return self._output.encode_messages(topic_id, (payload,))

    def encode_messages(self, topic_id: int, payloads: Sequence[bytes]) -> bytes:
        """Return the frames of several payloads, joined; all or nothing.

        Raises the same errors as encode_message.
        """
        return self._output.encode_messages(topic_id, payloads)

    def answer_time(self, time: Time, now_s: float) -> None:
        """Answer TimeRequested with the time at `now_s`; the answer waits during a call of the board."""
        self._output.queue_time(time, now_s)

    def answer_parameter(
        self, ints: Sequence[int] = (), floats: Sequence[float] = (), strings: Sequence[str] = ()
    ) -> None:
        """Answer ParameterRequested.

        Raises LocalProtocolError if the answer does not fit in the device's buffer, or a number in 32 bits.
        """
        self._output.queue_parameter(ParameterResponse(tuple(ints), tuple(floats), tuple(strings)))

    def service_call_started(self) -> None:
        """Hold back time answers: the board itself waits for a service response."""
        self._output.call_started()

    def service_call_finished(self, now_s: float) -> None:
        """Record that the call has ended. If there is a response, call this after its `encode_message`."""
        self._output.call_finished(now_s)

    def stop(self) -> None:
        """Queue the frame that asks the device to stop sending; from then on the link does nothing."""
        self._is_stopped = True
        self._output.queue_stop()

    def _listen(self) -> ProtocolDetector:
        return ProtocolDetector(max_payload_bytes=self._config.max_payload_bytes, limits=self._limits)

    def _handle_decoded(self, decoded: list[Decoded], now_s: float) -> list[HostEvent]:
        """Convert decoded frames to events."""
        events: list[HostEvent] = []
        if isinstance(self._line, ProtocolDetector) and self._line.decoder is not None:
            self._line = self._line.decoder
            self._learn_version(self._line.version, now_s, events)
        messages: list[Frames] = []
        for item in decoded:
            if isinstance(item, FrameDiscarded):
                self._report(item, now_s, events)
                continue
            if item.topic_id >= ids.FIRST_USER_ID:
                messages.append(item)
            else:
                self._handle_control(item, now_s, events)
        for item in messages:
            self._handle_messages(item, now_s, events)
        return events

    def _handle_messages(self, frames: Frames, now_s: float, events: list[HostEvent]) -> None:
        topic_id, payloads = frames.topic_id, frames.payloads
        if topic_id in self._table.senders:
            events.append(self._receive_messages(frames, now_s))
            return
        self._note_frames(frames, now_s)
        self.statistics.unannounced_messages += len(payloads)
        if self.is_settled and not self._announcements.is_refused_sender(topic_id):
            events.append(UnknownTopicId(topic_id, len(payloads)))
            if self._announcements.should_ask(topic_id, now_s):
                self._negotiation.ask(now_s, is_lossy=True)

    def _receive_messages(self, frames: Frames, now_s: float) -> MessagesReceived:
        self._note_frames(frames, now_s)
        self._presence.message_received(now_s)
        return MessagesReceived(frames.topic_id, frames.payloads)

    def _note_frames(self, frames: Frames, now_s: float) -> None:
        self.statistics.frames_received += len(frames.payloads)
        self._presence.frame_received(now_s)

    def _handle_control(self, frames: Frames, now_s: float, events: list[HostEvent]) -> None:
        self._note_frames(frames, now_s)
        payloads = frames.payloads
        admitted = self._rate.admit(frames.topic_id, len(payloads), now_s)
        if admitted < len(payloads):
            self._report(ControlFlood(frames.topic_id, len(payloads) - admitted), now_s, events)
            payloads = payloads[:admitted]
        if frames.topic_id == ids.TIME:
            self._on_time_requests(payloads, now_s, events)
            return
        for payload in payloads:
            if frames.topic_id in ids.ANNOUNCEMENTS:
                self._on_announcement(frames.topic_id, payload, now_s, events)
            else:
                self._report(_control_event(frames.topic_id, payload), now_s, events)

    def _on_announcement(self, kind: int, payload: bytes, now_s: float, events: list[HostEvent]) -> None:
        info, announced = self._announcements.handle_packet(kind, payload, now_s)
        for event in announced:
            self._report(event, now_s, events)
        if info is not None:
            self._presence.sign_received(now_s)
            self.unread.announced(info.buffer_size, now_s)
            self._negotiation.announced(kind, info, now_s)

    def _on_time_requests(self, payloads: list[bytes], now_s: float, events: list[HostEvent]) -> None:
        for payload in payloads:
            if len(payload) not in TIME_REQUEST_BYTES:
                self._report(FrameDiscarded(DiscardReason.PACKET, payload, ids.TIME), now_s, events)
                continue
            self.statistics.time_requests += 1
            events.append(TimeRequested())
            is_settled, is_listening = self.is_settled, self._negotiation.is_listening
            meaning = self._negotiation.time_requested(now_s)
            self.unread.time_requested(now_s)
            if meaning is TimeRequestMeaning.INTRODUCTION:
                self.unread.read_all(is_always=True)
                self._presence.answer_received(now_s)
                self._on_reset(now_s, events)
            elif is_settled:
                may_be_early = meaning is TimeRequestMeaning.ANSWER
                verdict = self._presence.time_request_received(now_s, may_be_early=may_be_early)
                self._judge(verdict, now_s, events)
            else:
                # A time request after the announcements may have waited for them: the next may be due sooner.
                self._presence.answer_received(now_s, is_timely=not is_listening)

    def _report(self, event: HostEvent, now_s: float, events: list[HostEvent]) -> None:
        if isinstance(event, FrameDiscarded):
            self.statistics.count_discarded(event.reason, len(event.data))
            if event.reason in DAMAGE:
                self._negotiation.note_damage(now_s)
        elif isinstance(event, ControlFlood):
            last = events[-1] if events else None
            if isinstance(last, ControlFlood) and last.topic_id == event.topic_id:
                events[-1] = ControlFlood(event.topic_id, last.count + event.count)
                return
        events.append(event)

    def _learn_version(self, version: int, now_s: float, events: list[HostEvent]) -> None:
        if version != self._version:
            _LOG.debug("%s: speaks protocol version %d", self._config.name, version)
            self._version = self._output.version = version
            events.append(ProtocolDetected(version))
        self.unread.version = version
        self._negotiation.set_version(version, now_s)

    def _settle(self, now_s: float, events: list[HostEvent]) -> None:
        negotiation = self._negotiation
        events += (changes := self._announcements.withdraw_all_but(negotiation.endpoints))
        if negotiation.rounds > 1:
            events += self._announcements.refuse_incomplete_services()
        self._presence.sign_received(now_s)
        if negotiation.round_trip_s is not None:
            self.statistics.note_round_trip(negotiation.round_trip_s)
        if changes or negotiation.requests:  # pragma: no branch - each settles after a request so far
            events.append(NegotiationSettled())

    def _judge(self, verdict: Verdict | None, now_s: float, events: list[HostEvent]) -> None:
        if verdict is Verdict.PROBE:
            self._output.queue_probe()
        elif verdict is Verdict.ASK:
            self._negotiation.ask(now_s)
        elif verdict is Verdict.RESET:
            self._on_reset(now_s, events)
        elif verdict is Verdict.SILENT:
            unfinished = self._line.abandon(now_s)
            self._line = self._listen()
            self.unread.forget()
            self._negotiation.set_version(None, now_s)
            self._negotiation.ask(now_s)
            events.append(DeviceSilent(now_s - self._presence.received_at_s))
            events += self._handle_decoded(unfinished, now_s)

    def _on_reset(self, now_s: float, events: list[HostEvent]) -> None:
        self.statistics.resets += 1
        self._output.device_reset()
        self._negotiation.forget_requests()
        if self.is_settled:  # otherwise the running negotiation already knows the board's endpoints
            self._table.mark_stale()
            self._negotiation.ask(now_s)
        events.append(DeviceReset())

    def _pump(self, now_s: float) -> None:
        if self._limits is not self._table.limits:
            self._limits = self._table.limits
            self._line.use_limits(self._limits)
        version = self._negotiation.pop_request()
        if version is not None:
            self._output.queue_topic_request(version, now_s, is_guess=self._negotiation.version is None)
        self._output.pump(now_s)


def _control_event(topic_id: int, payload: bytes) -> HostEvent:
    """Return the event of a control packet without state; FrameDiscarded if its id or layout is not valid."""
    event: HostEvent | None = None
    if topic_id == ids.LOG:
        log = Log.decode(payload)
        event = log and LogReceived(*log)
    elif topic_id == ids.PARAMETER:
        request = ParameterRequest.decode(payload)
        event = request and ParameterRequested(*request)
    else:
        return FrameDiscarded(DiscardReason.UNEXPECTED, payload)
    return event or FrameDiscarded(DiscardReason.PACKET, payload, topic_id)
