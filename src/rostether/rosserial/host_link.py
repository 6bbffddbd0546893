"""The host's end of a rosserial line (signatures; the machinery follows)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from rostether.rosserial.events import DiscardReason, HostEvent
from rostether.rostime import Time


@dataclass(frozen=True, slots=True)
class HostLinkConfig:
    """Limits and times of a host link; the defaults suit every board known."""

    max_payload_bytes: int = 65535
    max_endpoints: int = 512


@dataclass(slots=True)
class LinkStatistics:
    """Counters of one link since it started."""

    frames_received: int = 0
    bytes_received: int = 0
    frames_sent: int = 0
    bytes_sent: int = 0
    messages_received: dict[int, int] = field(default_factory=dict)
    messages_sent: dict[int, int] = field(default_factory=dict)
    discarded: dict[DiscardReason, int] = field(default_factory=dict)
    discarded_bytes: int = 0
    topic_requests: int = 0
    negotiations: int = 0
    resets: int = 0
    time_requests: int = 0
    time_answers: int = 0
    last_round_trip_s: float | None = None


class HostLink:
    """Speaks to one device. Bytes, messages and `now_s` (any monotonic clock) in; events and bytes out.

    After every call that may have changed something, send `data_to_send()` and wait for `get_timer()`.
    """

    def __init__(self, config: HostLinkConfig | None = None) -> None:
        self.statistics = LinkStatistics()

    @property
    def version(self) -> int | None:
        """The protocol version the device speaks, None until known."""
        raise NotImplementedError

    @property
    def is_settled(self) -> bool:
        """Whether the set of endpoints is taken to be complete."""
        raise NotImplementedError

    def start(self, now_s: float) -> None:
        """Begin: the first topic request is ready to be sent."""
        raise NotImplementedError

    def receive_data(self, data: bytes | bytearray | memoryview, now_s: float) -> list[HostEvent]:
        """Take a chunk from the device, cut anywhere. Never raises for what a device sends."""
        raise NotImplementedError

    def get_timer(self) -> float | None:
        """Return when `handle_timer` wants to be called, on the clock of `now_s`."""
        raise NotImplementedError

    def handle_timer(self, now_s: float) -> list[HostEvent]:
        """Do what is due by `now_s`; harmless when called early."""
        raise NotImplementedError

    def data_to_send(self) -> bytes:
        """Take the control frames that are waiting to be sent."""
        raise NotImplementedError

    def can_send(self, topic_id: int) -> bool:
        """Whether the device listens on this id now: announced, and announced again since its last reset."""
        raise NotImplementedError

    def encode_message(self, topic_id: int, payload: bytes) -> bytes:
        """Return the frame to send. Raises LocalProtocolError if `can_send` is false or the payload does not fit."""
        raise NotImplementedError

    def encode_messages(self, topic_id: int, payloads: Sequence[bytes]) -> bytes:
        """Return the frames of several payloads, joined; all or nothing. Raises as encode_message."""
        raise NotImplementedError

    def answer_time(self, time: Time, now_s: float) -> None:
        """Answer TimeRequested with what time it is at `now_s`; held back while a call of the board is in flight."""
        raise NotImplementedError

    def answer_parameter(
        self, ints: Sequence[int] = (), floats: Sequence[float] = (), strings: Sequence[str] = ()
    ) -> None:
        """Answer ParameterRequested. Raises LocalProtocolError if the answer does not fit the device's buffer."""
        raise NotImplementedError

    def service_call_started(self, now_s: float) -> None:
        """Tell that the board itself waits for a service response: time answers are held back."""
        raise NotImplementedError

    def service_call_finished(self, now_s: float) -> None:
        """Tell that the response was sent or given up; call it after encode_message of the response."""
        raise NotImplementedError

    def stop(self) -> None:
        """Queue the frame that tells the device to stop sending."""
        raise NotImplementedError
