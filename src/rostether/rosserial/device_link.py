"""The device's end of a rosserial line: behaves like the established library, without its known defects."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from msgspec import Struct

from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.device_endpoints import DeviceEndpoints
from rostether.rosserial.device_endpoints import ServiceIds as ServiceIds
from rostether.rosserial.device_parameters import ParameterQueue
from rostether.rosserial.device_state import TRANSITIONS, Input, State
from rostether.rosserial.events import (
    DeviceEvent,
    DiscardReason,
    FrameDiscarded,
    MessagesReceived,
    ParameterReceived,
    ParameterTimedOut,
    StopReceived,
    TimeAnswered,
    TopicsRequested,
    Unconfigured,
    UnknownTopicId,
)
from rostether.rosserial.frame import encode_frame, encode_frames
from rostether.rosserial.frame_decoder import Decoded, FrameDecoder
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.rosserial.packets import (
    PUBLISHER_OVERHEAD_BYTES,
    Log,
    LogLevel,
    ParameterRequest,
    ParameterResponse,
    decode_time,
    encode_time,
)
from rostether.rosserial.time_sync import OUR_REQUEST_PERIOD_S, SYNC_LOST_S, DeviceClock
from rostether.rostime import Time

# An unfinished frame must not hide a probe; the established library waits 20 ms, networks need more.
ABANDON_AFTER_S = 0.25

# Beyond this, nothing is published until the driver has sent some data: a second of a 10 Mbit line.
MAX_WAITING_BYTES = 1 << 20

# Beyond this, control frames are dropped too: a host that reads nothing must not fill the memory. It requests
# them again.
MAX_WAITING_CONTROL_BYTES = 2 * MAX_WAITING_BYTES

# The level, and the length of the text.
LOG_OVERHEAD_BYTES = 5


class DeviceLinkConfig(Struct, frozen=True):
    """The properties of the device; the defaults are those of the established library on a large board."""

    version: int = 2
    max_subscribers: int = 25
    max_publishers: int = 25
    input_buffer_bytes: int = 512
    output_buffer_bytes: int = 512


class DeviceLink:
    """The device's end of a line. Bytes, messages and `now_s` (any monotonic clock) in; events and bytes out.

    Declare endpoints first; those that are declared later are announced immediately. After every call that
    may have changed something, send `data_to_send()` and wait for `get_timer()`.
    """

    def __init__(self, config: DeviceLinkConfig | None = None) -> None:
        self.statistics = LinkStatistics()
        self._config = config or DeviceLinkConfig()
        self._endpoints = DeviceEndpoints(
            max_publishers=self._config.max_publishers,
            max_subscribers=self._config.max_subscribers,
            input_buffer_bytes=self._config.input_buffer_bytes,
            output_buffer_bytes=self._config.output_buffer_bytes,
        )
        self._actions: dict[str, Callable[[float, list[DeviceEvent]], None]] = {
            "ask_time": self._ask_time,
            "announce": self._announce,
            "fall_silent": self._fall_silent,
        }
        self._on_control: dict[int, Callable[[list[bytes], float, list[DeviceEvent]], None]] = {
            ids.TOPIC_REQUEST: self._on_topic_requests,
            ids.TIME: self._on_time_answers,
            ids.PARAMETER: self._on_parameters,
            ids.TX_STOP: self._on_stops,
        }
        self._outgoing: list[bytes] = []
        self._outgoing_bytes = 0
        self.start(0.0)

    def start(self, now_s: float) -> None:
        """Start or restart: unconfigured, with the clock at zero, and silent until a request."""
        self._state = State.UNCONFIGURED
        self._decoder = FrameDecoder(
            self._config.version,
            max_payload_bytes=self._config.input_buffer_bytes,
            abandon_after_s=ABANDON_AFTER_S,
        )
        self._clock = DeviceClock(now_s)
        self._time_due_s = now_s
        self._time_lost_s = now_s
        self._parameters = ParameterQueue()
        self._outgoing.clear()
        self._outgoing_bytes = 0

    @property
    def is_configured(self) -> bool:
        """Whether a host has requested the topics and still answers; messages are sent only then."""
        return self._state is State.CONFIGURED

    def add_publisher(self, topic: str, message_type: str, md5sum: str) -> int:
        """Declare a topic that the device publishes; return its id.

        Raises LocalProtocolError if there is no room for it, or if a host would reject it.
        """
        topic_id = self._endpoints.add_publisher(topic, message_type, md5sum)
        self._announce_late(topic_id)
        return topic_id

    def add_subscriber(self, topic: str, message_type: str, md5sum: str) -> int:
        """Declare a topic that the device subscribes to; return its id.

        Raises LocalProtocolError if there is no room for it, or if a host would reject it.
        """
        topic_id = self._endpoints.add_subscriber(topic, message_type, md5sum)
        self._announce_late(topic_id)
        return topic_id

    def add_service_server(
        self, service: str, service_type: str, request_md5sum: str, response_md5sum: str
    ) -> ServiceIds:
        """Declare a service that the device serves: requests arrive on request_id, publish on response_id.

        Raises LocalProtocolError if there is no room for it, or if a host would reject it.
        """
        service_ids = self._endpoints.add_service_server(
            service, service_type, request_md5sum, response_md5sum
        )
        self._announce_late(*service_ids)
        return service_ids

    def add_service_client(
        self, service: str, service_type: str, request_md5sum: str, response_md5sum: str
    ) -> ServiceIds:
        """Declare a service that the device calls: publish on request_id, responses arrive on response_id.

        Raises LocalProtocolError if there is no room for it, or if a host would reject it.
        """
        service_ids = self._endpoints.add_service_client(
            service, service_type, request_md5sum, response_md5sum
        )
        self._announce_late(*service_ids)
        return service_ids

    def _announce_late(self, *topic_ids: int) -> None:
        """Announce an endpoint that was declared after the host's request, which comes only once."""
        if self._state is State.CONFIGURED:
            for kind, info in self._endpoints.announcements():
                if info.topic_id in topic_ids:
                    self._queue_control(kind, info.encode())

    def receive_data(self, data: bytes | bytearray | memoryview, now_s: float) -> list[DeviceEvent]:
        """Process a chunk from the host, which may end anywhere. Never raises because of its data."""
        self.statistics.bytes_received += len(data)
        return self._handle_decoded(self._decoder.feed(data, now_s), now_s)

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, on the clock of `now_s`; None if nothing is scheduled."""
        timers = [self._decoder.get_timer(), self._parameters.get_timer()]
        if self._state is State.CONFIGURED:
            timers += [self._time_due_s, self._time_lost_s]
        return min((timer for timer in timers if timer is not None), default=None)

    def handle_timer(self, now_s: float) -> list[DeviceEvent]:
        """Do all work that is due by `now_s`; an early call has no effect."""
        events = self._handle_decoded(self._decoder.handle_timer(now_s), now_s)
        if now_s >= self._time_lost_s:
            self._advance(Input.TIME_LOST, now_s, events)
        if now_s >= self._time_due_s:
            self._advance(Input.TIME_DUE, now_s, events)
        name = self._parameters.pop_timed_out(now_s)
        if name is not None:
            events.append(ParameterTimedOut(name))
            self._send_parameter_request(self._parameters.next_to_send(now_s))
        return events

    def data_to_send(self) -> bytes:
        """Return the waiting bytes, and remove them from the queue."""
        data = b"".join(self._outgoing)
        self._outgoing.clear()
        self._outgoing_bytes = 0
        return data

    def publish(self, topic_id: int, payloads: Sequence[bytes]) -> bool:
        """Queue messages; return False without sending while unconfigured, or while too much data waits.

        Raises LocalProtocolError for an id the device does not send on, or a payload larger than its buffer.
        """
        if not self._endpoints.is_sender(topic_id):
            raise LocalProtocolError(f"the device does not send on topic id {topic_id}; declare it first")
        largest = max(map(len, payloads), default=0)
        room = self._config.output_buffer_bytes - PUBLISHER_OVERHEAD_BYTES
        if largest > room:
            raise LocalProtocolError(
                f"a message of {largest} bytes does not fit in the output buffer, which has room for {room} "
                "bytes; send smaller messages, or increase output_buffer_bytes"
            )
        if self._state is not State.CONFIGURED or self._outgoing_bytes > MAX_WAITING_BYTES:
            return False
        self._queue(encode_frames(topic_id, payloads, self._config.version))
        return True

    def log(self, level: LogLevel, text: str) -> None:
        """Queue a log line, truncated to the output buffer; it is sent even while unconfigured.

        It is dropped while too much data waits.
        """
        room = self._config.output_buffer_bytes - PUBLISHER_OVERHEAD_BYTES - LOG_OVERHEAD_BYTES
        truncated = text.encode("utf-8", "replace")[:room].decode("utf-8", "ignore")
        self._queue_control(ids.LOG, Log(level, truncated).encode())

    def request_parameter(self, name: str, now_s: float, *, timeout_s: float = 1.0) -> None:
        """Request a parameter; ParameterReceived or ParameterTimedOut follows. One request at a time is sent.

        Raises LocalProtocolError for a name that cannot be requested, or when too many requests wait.
        """
        self._send_parameter_request(self._parameters.add(name, timeout_s, now_s))

    def time(self, now_s: float) -> Time:
        """Return the device's clock: the host's time, or time since `start` until the host answered."""
        return self._clock.time(now_s)

    def _handle_decoded(self, decoded: list[Decoded], now_s: float) -> list[DeviceEvent]:
        events: list[DeviceEvent] = []
        is_probed = False
        for item in decoded:
            if isinstance(item, FrameDiscarded):
                is_probed = is_probed or item.reason is DiscardReason.VERSION
                self._discard(item.reason, item.data, events)
                continue
            self.statistics.frames_received += len(item.payloads)
            if item.topic_id in self._on_control:
                self._on_control[item.topic_id](item.payloads, now_s, events)
            elif self._endpoints.is_listener(item.topic_id):
                events.append(MessagesReceived(item.topic_id, item.payloads))
            else:
                self.statistics.unannounced_messages += len(item.payloads)
                events.append(UnknownTopicId(item.topic_id, len(item.payloads)))
        if is_probed and self._config.version == 2:
            self._advance(Input.WRONG_VERSION, now_s, events)
        return events

    def _on_topic_requests(self, payloads: list[bytes], now_s: float, events: list[DeviceEvent]) -> None:
        for payload in payloads:
            if payload:
                self._discard(DiscardReason.PACKET, payload, events)
        if not all(payloads):
            self._advance(Input.TOPIC_REQUEST, now_s, events)

    def _on_time_answers(self, payloads: list[bytes], now_s: float, events: list[DeviceEvent]) -> None:
        for payload in payloads:
            time = decode_time(payload)
            if time is None:
                self._discard(DiscardReason.PACKET, payload, events)
                continue
            self.statistics.note_round_trip(self._clock.answered(time, now_s))
            self._time_lost_s = now_s + SYNC_LOST_S
            events.append(TimeAnswered(time))

    def _on_parameters(self, payloads: list[bytes], now_s: float, events: list[DeviceEvent]) -> None:
        for payload in payloads:
            response = ParameterResponse.decode(payload)
            if response is None:
                self._discard(DiscardReason.PACKET, payload, events)
                continue
            name = self._parameters.pop_answered()
            if name is None:
                self._discard(DiscardReason.UNEXPECTED, payload, events)
                continue
            events.append(ParameterReceived(name, *response))
            self._send_parameter_request(self._parameters.next_to_send(now_s))

    def _on_stops(self, payloads: list[bytes], now_s: float, events: list[DeviceEvent]) -> None:
        events.append(StopReceived())
        self._advance(Input.STOP, now_s, events)

    def _advance(self, what: Input, now_s: float, events: list[DeviceEvent]) -> None:
        self._state, actions = TRANSITIONS.get((self._state, what), (self._state, ()))
        for action in actions:
            self._actions[action](now_s, events)

    def _ask_time(self, now_s: float, events: list[DeviceEvent]) -> None:
        self.statistics.time_requests += 1
        self._clock.requested(now_s)
        self._time_due_s = now_s + OUR_REQUEST_PERIOD_S
        self._queue_control(ids.TIME, encode_time(Time()))

    def _announce(self, now_s: float, events: list[DeviceEvent]) -> None:
        self._time_lost_s = now_s + SYNC_LOST_S
        for kind, info in self._endpoints.announcements():
            self._queue_control(kind, info.encode())
        events.append(TopicsRequested())

    def _fall_silent(self, now_s: float, events: list[DeviceEvent]) -> None:
        events.append(Unconfigured())

    def _send_parameter_request(self, name: str | None) -> None:
        if name is not None:
            self._queue_control(ids.PARAMETER, ParameterRequest(name).encode())

    def _discard(self, reason: DiscardReason, data: bytes, events: list[DeviceEvent]) -> None:
        self.statistics.count_discarded(reason, len(data))
        events.append(FrameDiscarded(reason, data))

    def _queue_control(self, topic_id: int, payload: bytes) -> None:
        if self._outgoing_bytes <= MAX_WAITING_CONTROL_BYTES:
            self._queue(encode_frame(topic_id, payload, self._config.version))

    def _queue(self, data: bytes) -> None:
        self._outgoing.append(data)
        self._outgoing_bytes += len(data)
