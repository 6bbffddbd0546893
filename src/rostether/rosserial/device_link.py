"""The device's end of a rosserial line (signatures; the machinery follows)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rostether.rosserial.events import DeviceEvent
from rostether.rosserial.packets import LogLevel
from rostether.rostime import Time


@dataclass(frozen=True, slots=True)
class DeviceLinkConfig:
    """What kind of device to be; the defaults are those of the established library on a large board."""

    version: int = 2
    max_subscribers: int = 25
    max_publishers: int = 25
    input_buffer_bytes: int = 512
    output_buffer_bytes: int = 512


class ServiceIds(NamedTuple):
    """The two topic ids of one service."""

    request_id: int
    response_id: int


class DeviceLink:
    """Speaks to a host. Bytes, messages and `now_s` (any monotonic clock) in; events and bytes out.

    Declare endpoints first; what is declared later reaches the host when it asks for topics again.
    After every call that may have changed something, send `data_to_send()` and wait for `get_timer()`.
    """

    def __init__(self, config: DeviceLinkConfig | None = None) -> None:
        self._config = config or DeviceLinkConfig()

    @property
    def is_configured(self) -> bool:
        """Whether a host has asked for the topics and still answers: only then messages are sent."""
        raise NotImplementedError

    def add_publisher(self, topic: str, message_type: str, md5sum: str) -> int:
        """Declare a topic the device sends on, return its id. Raises LocalProtocolError beyond max_publishers."""
        raise NotImplementedError

    def add_subscriber(self, topic: str, message_type: str, md5sum: str) -> int:
        """Declare a topic the device receives, return its id. Raises LocalProtocolError beyond max_subscribers."""
        raise NotImplementedError

    def add_service_server(
        self, service: str, service_type: str, request_md5sum: str, response_md5sum: str
    ) -> ServiceIds:
        """Declare a service the device serves: requests arrive on request_id, publish answers on response_id."""
        raise NotImplementedError

    def add_service_client(
        self, service: str, service_type: str, request_md5sum: str, response_md5sum: str
    ) -> ServiceIds:
        """Declare a service the device calls: publish requests on request_id, answers arrive on response_id."""
        raise NotImplementedError

    def start(self, now_s: float) -> None:
        """Boot, or boot again: unconfigured, clock at zero, nothing said until asked."""
        raise NotImplementedError

    def receive_data(self, data: bytes | bytearray | memoryview, now_s: float) -> list[DeviceEvent]:
        """Take a chunk from the host, cut anywhere. Never raises for what a host sends."""
        raise NotImplementedError

    def get_timer(self) -> float | None:
        """Return when `handle_timer` wants to be called, on the clock of `now_s`."""
        raise NotImplementedError

    def handle_timer(self, now_s: float) -> list[DeviceEvent]:
        """Do what is due by `now_s`; harmless when called early."""
        raise NotImplementedError

    def data_to_send(self) -> bytes:
        """Take the bytes that are waiting to be sent."""
        raise NotImplementedError

    def publish(self, topic_id: int, payloads: Sequence[bytes]) -> bool:
        """Queue messages; False (and nothing sent) while unconfigured or while too much waits to be sent.

        Raises LocalProtocolError for an id the device does not send on, or a payload larger than its buffer.
        """
        raise NotImplementedError

    def log(self, level: LogLevel, text: str) -> None:
        """Queue a log line; sent even while unconfigured."""
        raise NotImplementedError

    def request_parameter(self, name: str, now_s: float, *, timeout_s: float = 1.0) -> None:
        """Ask for a parameter; ends in ParameterReceived or ParameterTimedOut. One at a time on the wire."""
        raise NotImplementedError

    def time(self, now_s: float) -> Time:
        """Return the device's clock: the host's time, or time since `start` until the host answered."""
        raise NotImplementedError
