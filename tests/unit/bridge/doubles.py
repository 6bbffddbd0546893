"""Test doubles of the bridge's environment: reporters, transports, lines and clocks that record their use."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from typing import cast

from rostether.bridge.outbound.outbox import Outbox
from rostether.bridge.outbound.topic_queue import TopicQueue
from rostether.bridge.settings import DEFAULT_SETTINGS, BridgeSettings
from rostether.errors import LocalProtocolError
from rostether.graph.ports import Level
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.unread_bytes import UnreadBytes
from rostether.transports.board_keys import NO_PROOF
from rostether.transports.transport import Receiver


class RecordingReporter:
    """Keeps every line."""

    def __init__(self) -> None:
        self.lines: list[tuple[Level, str, str]] = []

    def report(self, level: Level, text: str, *, node: str = "") -> None:
        self.lines.append((level, text, node))

    @property
    def texts(self) -> list[str]:
        return [text for _, text, _ in self.lines]

    def having(self, part: str) -> list[str]:
        return [text for text in self.texts if part in text]


class ManualTimer:
    def __init__(self, due_s: float, callback: Callable[[], object]) -> None:
        self.due_s = due_s
        self.callback = callback
        self.is_cancelled = False

    def cancel(self) -> None:
        self.is_cancelled = True


class ManualLoop:
    """The part of an event loop that the outbox needs, with a clock that tests advance."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self._soon: list[Callable[[], object]] = []
        self._timers: list[ManualTimer] = []

    def time(self) -> float:
        return self.now_s

    def call_soon(self, callback: Callable[[], object]) -> object:
        self._soon.append(callback)
        return None

    def call_later(self, delay: float, callback: Callable[[], object]) -> asyncio.TimerHandle:
        timer = ManualTimer(self.now_s + delay, callback)
        self._timers.append(timer)
        return cast(asyncio.TimerHandle, timer)

    def turn(self) -> None:
        """Run the callbacks that are due now, once."""
        soon, self._soon = self._soon, []
        for callback in soon:
            callback()

    def run_until(self, end_s: float) -> None:
        """Advance the clock, and run all callbacks in order."""
        while True:
            while self._soon:
                self.turn()
            due = [timer for timer in self._timers if not timer.is_cancelled and timer.due_s <= end_s]
            if not due:
                self.now_s = end_s
                return
            timer = min(due, key=lambda each: each.due_s)
            self._timers.remove(timer)
            self.now_s = max(self.now_s, timer.due_s)
            timer.callback()


class FakeTransport:
    """Collects written bytes; `write_buffer_bytes` is the number of bytes that it reports as unsent."""

    def __init__(self, *, can_pause: bool = True) -> None:
        self.can_pause = can_pause
        self.peer = "fake board"
        self.remote: str | None = None
        self.proof = NO_PROOF
        self.writes: list[bytes] = []
        self.write_buffer_bytes = 0

    def start(self, receiver: Receiver) -> None:
        pass

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.writes.append(bytes(data))

    def pause_reading(self) -> None:
        pass

    def resume_reading(self) -> None:
        pass

    def close(self) -> None:
        pass

    async def wait_closed(self) -> None:
        pass

    @property
    def written(self) -> bytes:
        return b"".join(self.writes)


class FakeSerialPort(FakeTransport):
    """A port whose line carries `bytes_per_s` on the manual clock; it reports its unsent bytes."""

    def __init__(self, loop: ManualLoop, bytes_per_s: float) -> None:
        self._loop = loop
        self._bytes_per_s = bytes_per_s
        self._idle_at_s = 0.0
        super().__init__(can_pause=False)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        super().write(data)
        self._idle_at_s = max(self._idle_at_s, self._loop.time()) + len(data) / self._bytes_per_s

    @property
    def write_buffer_bytes(self) -> int:
        return int(max(0.0, self._idle_at_s - self._loop.time()) * self._bytes_per_s)

    @write_buffer_bytes.setter
    def write_buffer_bytes(self, count_bytes: int) -> None:
        assert count_bytes == 0


class FakeLink:
    """Encodes a message as `<id>:payload;`, so that tests can read what was sent."""

    def __init__(self) -> None:
        self.control: list[bytes] = []
        self.refused: set[int] = set()
        self.limit_bytes = 65535
        self.unread = UnreadBytes()

    def data_to_send(self) -> bytes:
        control, self.control = self.control, []
        return b"".join(control)

    def encode_message(self, topic_id: int, payload: bytes) -> bytes:
        return self.encode_messages(topic_id, [payload])

    def encode_messages(self, topic_id: int, payloads: Sequence[bytes]) -> bytes:
        if topic_id in self.refused:
            raise LocalProtocolError(f"topic id {topic_id} is not announced")
        if max(map(len, payloads)) > self.limit_bytes:
            raise LocalProtocolError(
                f"a payload is larger than the board's buffer of {self.limit_bytes} bytes"
            )
        return b"".join(b"%d:%b;" % (topic_id, payload) for payload in payloads)


class FakeSource:
    """A subscription that records whether it was paused."""

    topic = "/chatter"
    publisher_count = 1

    def __init__(self) -> None:
        self.is_paused = False

    def pause(self) -> None:
        self.is_paused = True

    def resume(self) -> None:
        self.is_paused = False

    async def close(self) -> None:
        self.is_paused = False


class FakeLine:
    """A `BoardLine` whose board is the test."""

    def __init__(self, *, can_pause: bool = True, settings: BridgeSettings = DEFAULT_SETTINGS) -> None:
        self.receivers: dict[int, Callable[[list[bytes]], None]] = {}
        self.transport = FakeTransport(can_pause=can_pause)
        self.link = FakeLink()
        self.waits: list[Callable[[], Awaitable[object]]] = []
        self.calls_started = 0
        self.looked_inside: list[bytes] = []
        self.calls_finished = 0
        self.dropped: list[tuple[str, int]] = []
        self.outbox = Outbox(
            self.transport,
            cast(HostLink, self.link),
            asyncio.get_running_loop(),
            on_dropped=self._note_dropped,
            settings=settings,
        )

    def pause_until(self, wait: Callable[[], Awaitable[object]]) -> bool:
        if self.transport.can_pause:
            self.waits.append(wait)
        return self.transport.can_pause

    def rescan(self, payload: bytes) -> None:
        self.looked_inside.append(payload)

    def call_started(self) -> None:
        self.calls_started += 1

    def call_finished(self) -> None:
        self.calls_finished += 1

    def _note_dropped(self, queue: TopicQueue, count: int) -> None:
        self.dropped.append((queue.topic, count))
