"""Finds out whether a port speaks rosserial, and its baud rate and protocol version.

A board that receives a topic request at its own rate answers immediately; at any other rate it receives noise
and does not answer. The rates are therefore tried one after another. The likely ones come first, and are
repeated while a bootloader may still run. A board that was configured before sends messages without a
request; at a wrong rate, they are noise. But 230400 and 250000 baud are so close that short frames are
received correctly. One of these rates is accepted only if few of its bytes are damaged.

    phase    until                              then
    LISTEN   1.2 s of silence                   ASK                       (only if asked to listen first)
             bytes arrived                      SURVEY
    SURVEY   listened 1.1 s at each rate        ASK, if quiet for long enough; else the end: not a board
             text arrived twice at one rate     the end: not a board
    ASK      two requests at each rate          the end: no answer
    any      frames that only a board sends     the end: found
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import Enum, auto

from msgspec import Struct

from rostether.rosserial.events import FrameDiscarded, HostEvent
from rostether.rosserial.host_link import HostLink

# By frequency in sketches: the library's default first, then the rates in tutorials.
USUAL_BAUDS = (57600, 115200, 9600, 250000, 500000, 1000000, 38400, 19200, 230400, 460800, 921600, 2000000)

# Opening a port resets many boards; their bootloaders take up to 2 s.
BOOT_S = 2.5

# The two likeliest rates alternate while a bootloader may run.
FIRST_DWELL_S = 0.5

# Two requests; most sketches answer within 50 ms.
QUICK_DWELL_S = 0.35

# Four requests, one of them in version 1; for a sketch whose loop() takes half a second.
PATIENT_DWELL_S = 0.9

# A GPS receiver sends once a second.
LISTEN_S = 1.2

# Also longer than the period of a GPS receiver. A port sends text if two such periods at one rate have text.
SURVEY_DWELL_S = 1.1

# Bytes before this pause were a boot message.
QUIET_S = 4.0

# Noise looks like one message on an unknown topic id once in 65,536 tries; two are a board.
MIN_MESSAGES = 2

# Rates closer than this read some of each other's frames: bits are sampled at most 0.8 bits too late.
NEAR_RATIO = 1.12

# At a near rate, the bytes after the first frame have arrived within this time.
CONFIRM_S = 0.1

# At a near rate, the largest damaged share of the bytes; at the wrong one, more than half is damaged.
MAX_DAMAGE = 0.25

# Noise looks like text of this length once in a million tries.
MIN_TEXT_BYTES = 16

# Bytes at the right rate are passed on, so that no announcement is lost: room for 256 announcements of 250
# bytes.
MAX_KEPT_BYTES = 64 * 1024

# The bytes of another protocol that are shown: a line of text.
SHOWN_BYTES = 60


class Step(Enum):
    """The purpose of a period at one rate."""

    LISTEN = auto()
    SURVEY = auto()
    ASK = auto()


class BoardFound(Struct, frozen=True):
    """A board. `received` are the bytes at its rate, for the link that serves it."""

    baud: int
    version: int
    received: bytes


class NoBoard(Struct, frozen=True):
    """No board: the number of unknown bytes, and if they were text, the text and its rate."""

    foreign_bytes: int
    text: bytes = b""
    text_baud: int | None = None


class BaudProbe:
    """Probes one open port. Set the line to `baud` whenever that changes, and send `data_to_send()`.

    With `listens_first`, nothing is sent before the line has been silent, and never to a device that sends
    other data. `known_baud` is the rate at which the board answered last time.
    """

    def __init__(
        self,
        bauds: Sequence[int] = USUAL_BAUDS,
        *,
        known_baud: int | None = None,
        listens_first: bool = False,
    ) -> None:
        if known_baud is not None:
            bauds = (known_baud, *(baud for baud in bauds if baud != known_baud))
        self._bauds = tuple(bauds)
        self._likely = self._bauds[:1] if known_baud is not None else self._bauds[:2]
        self._steps = self._listening_steps() if listens_first else self._ask_steps()
        self._step = Step.ASK
        self._until_s = 0.0
        self._link = HostLink()
        self._received = bytearray()
        self._noise = bytearray()
        self._foreign_bytes = 0
        self._received_at_s = float("-inf")
        self._text: tuple[int, bytes] | None = None
        self._is_doubted = False
        self._damaged: BoardFound | None = None
        self.baud = self._bauds[0]
        self.result: BoardFound | NoBoard | None = None

    def start(self, now_s: float) -> None:
        """Start to probe."""
        self._next(now_s)

    def receive_data(self, data: bytes, now_s: float) -> None:
        """Handle a chunk from the port."""
        if self.result is not None:
            return
        self._received += data[: MAX_KEPT_BYTES - len(self._received)]
        self._received_at_s = now_s
        self._handle_events(self._link.receive_data(data, now_s), now_s)

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, on the clock of `now_s`; None after the end."""
        if self.result is not None:
            return None
        timer_s = self._link.get_timer()
        return self._until_s if timer_s is None else min(timer_s, self._until_s)

    def handle_timer(self, now_s: float) -> None:
        """Handle the link's timer, and try the next rate when it is due."""
        if self.result is not None:
            return
        self._handle_events(self._link.handle_timer(now_s), now_s)
        if self.result is None and now_s >= self._until_s:
            if self._is_doubted:
                self._judge_damage()
            self._judge_text()
            if self.result is None:
                self._next(now_s)

    def data_to_send(self) -> bytes:
        """Return the bytes to send now; none while it only listens."""
        data = self._link.data_to_send()
        return data if self._step is Step.ASK and self.result is None else b""

    def _handle_events(self, events: Sequence[HostEvent], now_s: float) -> None:
        for event in events:
            if isinstance(event, FrameDiscarded):
                self._foreign_bytes += len(event.data)
                self._noise += event.data[: SHOWN_BYTES - len(self._noise)]
        statistics, version = self._link.statistics, self._link.version
        control = statistics.frames_received - statistics.unannounced_messages
        if version is not None and (control > 0 or statistics.unannounced_messages >= MIN_MESSAGES):
            if not self._has_near_rate():
                self.result = self._found(version)
            elif not self._is_doubted:
                self._is_doubted = True
                self._until_s = now_s + CONFIRM_S

    def _found(self, version: int) -> BoardFound:
        return BoardFound(self.baud, version, bytes(self._received))

    def _has_near_rate(self) -> bool:
        return any(1 < max(baud / self.baud, self.baud / baud) < NEAR_RATIO for baud in self._bauds)

    def _judge_damage(self) -> None:
        statistics, version = self._link.statistics, self._link.version
        if version is None:  # pragma: no cover - a device falls silent later than this
            return
        if statistics.discarded_bytes <= MAX_DAMAGE * statistics.bytes_received:
            self.result = self._found(version)
        elif self._damaged is None:
            self._damaged = self._found(version)

    def _next(self, now_s: float) -> None:
        following = next(self._steps, None)
        if following is None or (following[0] is Step.ASK and self._is_busy(now_s)):
            text_baud, text = self._text if self._text is not None else (None, b"")
            self.result = self._damaged or NoBoard(self._foreign_bytes, text or bytes(self._noise), text_baud)
            if self._damaged is not None:
                self.baud = self._damaged.baud
            return
        self._step, self.baud, duration_s = following
        self._until_s = now_s + duration_s
        self._link = HostLink()
        self._received.clear()
        self._noise.clear()
        self._is_doubted = False
        if self._step is Step.ASK:
            self._link.start(now_s)

    def _is_busy(self, now_s: float) -> bool:
        """Return whether the device still sends without a request, unlike a board that waits for one."""
        return self._step is not Step.ASK and now_s - self._received_at_s < QUIET_S

    def _judge_text(self) -> None:
        if len(self._noise) < MIN_TEXT_BYTES or not _is_text(self._noise):
            return
        if self._step is Step.SURVEY and self._text is not None and self._text[0] == self.baud:
            self.result = NoBoard(self._foreign_bytes, bytes(self._noise), self.baud)
        else:
            self._text = self.baud, bytes(self._noise)

    def _listening_steps(self) -> Iterator[tuple[Step, int, float]]:
        yield Step.LISTEN, self._bauds[0], LISTEN_S
        if self._received_at_s > float("-inf"):
            for baud in self._bauds:
                yield Step.SURVEY, baud, SURVEY_DWELL_S
                if self._text is not None and self._text[0] == baud:
                    yield Step.SURVEY, baud, SURVEY_DWELL_S
        yield from self._ask_steps()

    def _ask_steps(self) -> Iterator[tuple[Step, int, float]]:
        spent_s, turn = 0.0, 0
        while spent_s < BOOT_S:
            yield Step.ASK, self._likely[turn % len(self._likely)], FIRST_DWELL_S
            spent_s += FIRST_DWELL_S
            turn += 1
        for duration_s in (QUICK_DWELL_S, PATIENT_DWELL_S):
            for baud in self._bauds:
                yield Step.ASK, baud, duration_s


def _is_text(noise: bytes | bytearray) -> bool:
    printable = sum(32 <= byte < 127 or byte in b"\t\r\n" for byte in noise)
    return printable * 10 >= len(noise) * 9
