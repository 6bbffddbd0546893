"""The output to a device: messages that fit in its buffer, and control frames at the right time."""

from __future__ import annotations

from collections.abc import Sequence

from rostether.errors import LocalProtocolError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame, encode_frames
from rostether.rosserial.link_statistics import LinkStatistics
from rostether.rosserial.packets import ParameterResponse, encode_time
from rostether.rosserial.time_sync import AnswerGate
from rostether.rosserial.topic_table import TopicTable
from rostether.rosserial.unread_bytes import UnreadBytes
from rostether.rostime import Time

# A frame with a wrong version byte: an unconfigured board requests the time, a configured one ignores it.
PROBE = b"\xff\x00"

# Sent before and after a version 1 request while the version is not known. Without it, a sketch that reads
# two requests at once would mistake the last `ff` of one for the start of the next.
OTHER_VERSION_GUARD = b"\x00"

# For a device without endpoints: the established library's buffers on an ATmega328P, a small common chip.
DEFAULT_INPUT_BUFFER_BYTES = 280

# The limit of unsent frames: a few hundred bytes a minute are normal, so a driver that holds more is stuck.
MAX_WAITING_BYTES = 1 << 16


class HostOutput:
    """Queue of control frames, and encoder of messages."""

    def __init__(
        self, table: TopicTable, statistics: LinkStatistics, unread: UnreadBytes | None = None
    ) -> None:
        self.version: int | None = None
        self._unread = unread or UnreadBytes()
        self._table = table
        self._statistics = statistics
        self._gate = AnswerGate()
        self._time: tuple[Time, float | None] | None = None
        self._request: tuple[int, bool] | None = None
        self._waiting: list[bytes] = []
        self._waiting_bytes = 0

    def pop_ready(self) -> bytes:
        """Return the control frames that may be sent now."""
        data = b"".join(self._waiting)
        self._waiting.clear()
        self._waiting_bytes = 0
        return data

    def encode_messages(self, topic_id: int, payloads: Sequence[bytes]) -> bytes:
        """Return the frames of messages. Raises LocalProtocolError if one may not be sent or does not fit."""
        limit = self._table.send_limits.get(topic_id)
        if limit is None:
            raise LocalProtocolError(
                f"the device has not announced a subscriber with topic id {topic_id}; wait until it has"
            )
        largest = max(map(len, payloads), default=0)
        if largest > limit:
            raise LocalProtocolError(
                f"a message of {largest} bytes does not fit in the device's buffer of {limit} bytes on topic "
                f"id {topic_id}; send smaller messages or build the sketch with a larger buffer"
            )
        data = encode_frames(topic_id, payloads, self.version or 2)
        if self._unread.room_bytes is not None:
            self._unread.sent(len(data))
        return data

    def queue_parameter(self, response: ParameterResponse) -> None:
        """Queue the answer to a parameter request; even an empty one takes 12 bytes.

        Raises LocalProtocolError if it does not fit.
        """
        payload = response.encode()
        limit = self._table.input_buffer_bytes
        limit = DEFAULT_INPUT_BUFFER_BYTES if limit is None else limit
        if len(payload) > limit:
            raise LocalProtocolError(
                f"the answer needs {len(payload)} bytes, but the device's buffer has {limit};"
                " shorten the parameter, or build the sketch with a larger buffer"
            )
        self._queue_frame(ids.PARAMETER, payload)

    def queue_time(self, time: Time, now_s: float) -> None:
        """Queue a time answer, or hold it back."""
        self._time = time, now_s
        self.pump(now_s)

    def queue_topic_request(self, version: int, now_s: float, *, is_guess: bool) -> None:
        """Queue a topic request, or hold it back. `is_guess`: the device may speak the other version."""
        self._request = version, is_guess
        self.pump(now_s)

    def queue_probe(self) -> None:
        """Queue a probe; not in version 1, because its devices do not answer a wrong version byte."""
        if self.version == 2:
            self._unread.sent(len(PROBE))
            self._queue(PROBE)

    def queue_stop(self) -> None:
        """Drop all waiting frames, and queue the stop frame."""
        self._waiting.clear()
        self._time = self._request = None
        self._gate.release()
        self._queue_frame(ids.TX_STOP, b"")

    def call_started(self) -> None:
        """Hold back frames that would end the device's wait for a service response."""
        self._gate.call_started()

    def call_finished(self, now_s: float) -> None:
        """Release the frames that waited for this call."""
        self._gate.call_finished()
        self.pump(now_s)

    def device_reset(self) -> None:
        """Forget calls and unread bytes: a device that was reset waits for nothing."""
        self._gate.forget_calls()
        self._unread.read_all()

    def get_timer(self) -> float | None:
        """Return when to call `pump`, None if no frame waits."""
        return self._gate.get_timer()

    def pump(self, now_s: float) -> None:
        """Queue the waiting frames, if they may be sent now."""
        if self._time is None and self._request is None:
            return
        if self._gate.is_closed(now_s):
            self._gate.hold(now_s)
            return
        self._gate.release()
        if self._request is not None:
            version, is_guess = self._request
            self._request = None
            self._statistics.topic_requests += 1
            guard = OTHER_VERSION_GUARD if is_guess and version == 1 else b""
            request = guard + encode_frame(ids.TOPIC_REQUEST, b"", version) + guard
            self._unread.requested(version, len(request), now_s)
            self._queue(request)
        if self._time is not None:
            time, stamped_s = self._time
            if not self._unread.has_room_for_time:
                # The established library adds the whole wait to the stamp.
                self._time = time, None
                return
            self._time = None
            late_ns = 0 if stamped_s is None else round((now_s - stamped_s) * 1e9)
            answer = encode_frame(
                ids.TIME, encode_time(Time.from_ns(time.to_ns() + late_ns)), self.version or 2
            )
            self._unread.sent(len(answer), is_time=True)
            self._queue(answer)

    def _queue_frame(self, topic_id: int, payload: bytes) -> None:
        self._queue(encode_frame(topic_id, payload, self.version or 2))

    def _queue(self, data: bytes) -> None:
        self._waiting.append(data)
        self._waiting_bytes += len(data)
        while self._waiting_bytes > MAX_WAITING_BYTES:
            self._waiting_bytes -= len(self._waiting.pop(0))
