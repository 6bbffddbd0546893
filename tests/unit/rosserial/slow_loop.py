"""A sketch that sleeps in its loop(), on our client library or the established one, and its host."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, auto

from msgspec.structs import replace

from rostether.bridge.outbound.topic_queue import FRAME_OVERHEAD_BYTES
from rostether.rosserial import topic_id as ids
from rostether.rosserial.events import DeviceReset, HostEvent, TimeRequested, TopicAnnounced
from rostether.rosserial.frame_decoder import FrameDecoder, Frames
from rostether.rosserial.host_link import HostLink
from rostether.rosserial.packets import TIME_BYTES
from rostether.rostime import Time
from unit.rosserial.decoding import frame
from unit.rosserial.host_link_boards import BURST, CHATTER, LED, TIME

STREAMED = replace(CHATTER, buffer_size=0xFFFF)
TOPICS = frame(ids.PUBLISHER, STREAMED.encode()) + frame(ids.SUBSCRIBER, LED.encode())
ESTABLISHED_TOPICS = BURST[len(TIME) :]
INTRODUCTION = TOPICS + TIME
SYNC_PERIOD_S = 2.2
MAX_UNANSWERED = 4
LINE_S = 0.003
# The receive buffer of an AVR's UART in Arduino's core.
UART_BYTES = 63


class Library(Enum):
    """How a client library answers topic requests, and what it does after a reset."""

    ONE_PER_SPIN = auto()
    """Requests the time after a reset, and answers the first topic request in each spinOnce."""
    EACH_AT_ONCE = auto()
    """Requests the time after a reset, and answers all requests in one spinOnce, each with a burst."""
    ONCE_FOR_ALL = auto()
    """Requests the time after a reset, and answers all requests in one spinOnce with one burst."""
    ESTABLISHED = auto()
    """Sends nothing until a request or a probe, and answers the first topic request in each spinOnce."""


@dataclass
class SlowLoop:
    """Calls spinOnce every `loop_s`, beginning at `booted_s`."""

    library: Library
    loop_s: float
    booted_s: float = 0.0
    boots: int = 0
    received: list[bytes] = field(default_factory=list)
    _uart: bytearray = field(default_factory=bytearray)
    _inbox: list[tuple[int, bytes] | None] = field(default_factory=list)
    _is_connected: bool = False
    _unanswered: int = 0

    def __post_init__(self) -> None:
        self.boot(self.booted_s)

    def boot(self, now_s: float) -> None:
        """Start, or start again: the state and the waiting bytes are lost."""
        self.boots += 1
        self._decoder = FrameDecoder(2, abandon_after_s=0.2)
        self._uart.clear()
        self._inbox.clear()
        self._is_connected = False
        self._unanswered = 0
        self.spin_s = now_s
        self._requested_s = float("-inf")

    def receive(self, data: bytes, now_s: float) -> None:
        """Keep the host's bytes for the next spinOnce, if the board is on and its UART has room."""
        if now_s >= self.booted_s:
            self._uart += data[: UART_BYTES - len(self._uart)]

    def skip_idle_spins(self, until_s: float) -> None:
        """Skip the calls of spinOnce before a time that find nothing and send nothing."""
        if not (self._uart or self._inbox):
            until_s = min(until_s, self._requested_s + SYNC_PERIOD_S)
            while self.spin_s < until_s:
                self.spin_s += self.loop_s

    def spin(self) -> bytes:
        """Call spinOnce; return what is sent."""
        now_s, self.spin_s = self.spin_s, self.spin_s + self.loop_s
        sent = b""
        stops_at_request = self.library in (Library.ONE_PER_SPIN, Library.ESTABLISHED)
        while self._uart or self._inbox:
            if not self._inbox:
                self._read(1 if stops_at_request else UART_BYTES, now_s)
                continue
            item = self._inbox.pop(0)
            if item is None:
                if not self._is_connected:
                    sent += self._ask_time(now_s)
            elif item == (ids.TOPIC_REQUEST, b""):
                sent += self._answer(now_s)
                if stops_at_request:
                    return sent
            elif item[0] == ids.TIME and len(item[1]) == TIME_BYTES:
                self._unanswered = 0
                self._is_connected = self._is_connected or self.library is not Library.ESTABLISHED
            elif item[0] == LED.topic_id:
                self.received.append(item[1])
        return sent + self._keep_in_touch(now_s)

    def _read(self, count: int, now_s: float) -> None:
        data = bytes(self._uart[:count])
        del self._uart[:count]
        for item in self._decoder.feed(data, now_s):
            if isinstance(item, Frames):
                self._inbox += [(item.topic_id, payload) for payload in item.payloads]
            else:
                self._inbox.append(None)

    def _answer(self, now_s: float) -> bytes:
        self._is_connected = True
        self._unanswered = 0
        if self.library is Library.ONCE_FOR_ALL:
            self._inbox = [item for item in self._inbox if item != (ids.TOPIC_REQUEST, b"")]
        is_ours = self.library is not Library.ESTABLISHED
        return self._ask_time(now_s) + (TOPICS if is_ours else ESTABLISHED_TOPICS)

    def _keep_in_touch(self, now_s: float) -> bytes:
        if now_s - self._requested_s < SYNC_PERIOD_S:
            return b""
        if self.library is Library.ESTABLISHED:
            return self._ask_time(now_s) if self._is_connected else b""
        if self._unanswered == MAX_UNANSWERED:
            self._is_connected = False
        self._unanswered += 1
        introduction = b"" if self._is_connected else TOPICS
        return introduction + self._ask_time(now_s)

    def _ask_time(self, now_s: float) -> bytes:
        self._requested_s = now_s
        return TIME


def meet(
    board: SlowLoop, end_s: float, resets_s: Sequence[float] = (), message: bytes | None = None
) -> list[tuple[float, HostEvent]]:
    """Let a host and the board run until `end_s`, with resets of the board; return what the host reports.

    The host sends the message as soon as it knows the topic and the board has room.
    """
    link = HostLink()
    link.start(0.0)
    knows_topic = False
    events: list[tuple[float, HostEvent]] = []
    on_line: list[tuple[float, bytes]] = []
    resets = list(resets_s)
    now_s = 0.0
    while now_s < end_s:
        data = link.data_to_send()
        if message is not None and knows_topic and has_room(link, message):
            data += link.encode_message(LED.topic_id, message)
            message = None
        if data:
            on_line.append((now_s + LINE_S, data))
        due = [end_s, *resets[:1], *(at_s for at_s, _ in on_line[:1])]
        if (timer_s := link.get_timer()) is not None:
            due.append(timer_s)
        board.skip_idle_spins(min(due))
        now_s = max(now_s, min(board.spin_s, *due))
        found: list[HostEvent] = []
        if resets and resets[0] <= now_s:
            board.boot(resets.pop(0))
        while on_line and on_line[0][0] <= now_s:
            board.receive(on_line.pop(0)[1], now_s)
        if board.spin_s <= now_s:
            sent = board.spin()
            found += link.receive_data(sent, now_s)
        found += link.handle_timer(now_s)
        for event in found:
            events.append((now_s, event))
            if isinstance(event, TopicAnnounced) and event.info == LED:
                knows_topic = True
            elif isinstance(event, TimeRequested):
                link.answer_time(Time.from_s(1_700_000_000 + now_s), now_s)
    return events


def has_room(link: HostLink, message: bytes) -> bool:
    """Return whether the link lets the outbox send a message now."""
    return (room_bytes := link.unread.room_bytes) is None or room_bytes >= len(message) + FRAME_OVERHEAD_BYTES


def resets_of(events: list[tuple[float, HostEvent]]) -> list[float]:
    """Return when the host reported a reset."""
    return [at_s for at_s, event in events if isinstance(event, DeviceReset)]
