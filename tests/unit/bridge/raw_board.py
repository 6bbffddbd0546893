"""A board for tests that works with bytes: it answers topic requests, stores what it receives, and sends any
bytes.
"""

from __future__ import annotations

from collections import defaultdict

from rostether.errors import TransportError
from rostether.rosserial import topic_id as ids
from rostether.rosserial.frame import encode_frame
from rostether.rosserial.packets import Log, LogLevel, ParameterRequest, TopicInfo
from rostether.transports.memory import MemoryTransport

TOPIC_REQUEST = b"\xff\xfe\x00\x00\xff\x00\x00\xff"


class RawBoard:
    """The board's end of a memory pair; `announcements` are (kind, info) pairs in the order they are sent."""

    def __init__(self, transport: MemoryTransport, *announcements: tuple[int, TopicInfo]) -> None:
        self.transport = transport
        self.announcements = list(announcements)
        self.received: dict[int, list[bytes]] = defaultdict(list)
        self.order: list[int] = []
        self.is_mute = False
        self.is_lost = False
        self._unread = b""
        transport.start(self)

    def data_received(self, data: bytes) -> None:
        """Split the host's data into frames; only probes and guards may be between them."""
        unread = self._unread + data
        start = 0
        while len(unread) - start >= 8:
            if unread[start : start + 2] != b"\xff\xfe":
                start += 1
                continue
            size = int.from_bytes(unread[start + 2 : start + 4], "little")
            end = start + size + 8
            if end > len(unread):
                break
            frame = unread[start:end]
            topic_id = int.from_bytes(frame[5:7], "little")
            assert frame == encode_frame(topic_id, frame[7:-1])
            self._take(topic_id, frame[7:-1])
            start = end
        self._unread = unread[start:]

    def send(self, topic_id: int, *payloads: bytes) -> None:
        """Send frames in one chunk."""
        self.transport.write(b"".join(encode_frame(topic_id, payload) for payload in payloads))

    def log(self, level: LogLevel, text: str) -> None:
        self.send(ids.LOG, Log(level, text).encode())

    def ask_time(self) -> None:
        self.send(ids.TIME, bytes(8))

    def ask_parameter(self, name: str) -> None:
        self.send(ids.PARAMETER, ParameterRequest(name).encode())

    def connection_lost(self, error: TransportError | None) -> None:
        self.is_lost = True

    def pause_writing(self) -> None:
        """Ignored: a test that sends too much watches the transport itself."""

    def resume_writing(self) -> None:
        """Ignored, for the same reason."""

    def _take(self, topic_id: int, payload: bytes) -> None:
        self.received[topic_id].append(payload)
        self.order.append(topic_id)
        if topic_id == ids.TOPIC_REQUEST and not self.is_mute:
            self.ask_time()
            for kind, info in self.announcements:
                self.send(kind, info.encode())
