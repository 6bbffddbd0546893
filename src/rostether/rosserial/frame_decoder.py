"""From a byte stream to frames: keeps what is unfinished, and does not let it swallow what follows.

States and what moves between them:

    EMPTY    nothing kept               -- bytes end within a frame -->     WAITING
    WAITING  a frame has begun          -- its last byte arrives -->        EMPTY or WAITING (for the next)
             (or its first bytes)       -- time to look, frames inside -->  EMPTY or WAITING (it was noise)
                                        -- time to look, none inside -->    WAITING, looking half as often

A header in noise may claim 65535 bytes. One that claims more than its topic can have is refused at once.
When is it time to look inside another for frames that it swallows? For a frame whose topic and length are
known to be possible, when its bytes have stalled; for any other, soon after it began, even while bytes flow.
A possible one too is given up while bytes flow if its last ones are several sound frames on end: boards do
not send those in a message. Looking destroys nothing: without a complete frame inside there is nothing to
gain by giving up, and a slow network may yet bring the rest.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import TypeAlias

from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame import FORMS, MAX_PAYLOAD_BYTES, SYNC, Header, read_header
from rostether.rosserial.frame_scan import FrameScanner, Patience, Scan
from rostether.rosserial.payload_limits import NO_LIMITS, PayloadLimits

# Longer than pauses inside a frame on a working line (USB polls, operating system), mostly below 20 ms.
FIRST_LOOK_S = 0.1

# A frame that has had no byte for this long is not just coming in.
RECEIVING_S = 0.05

# Looks get rarer, so that hostile input costs little; this bounds how late a swallowed frame is found.
MAX_LOOK_S = 1.0

# This many valid frames in a row are traffic that a false header has covered; by chance one in 65,536 is
# valid.
TELLING_FRAMES = 3

# Places where no frame begins after all, 2.5 to 6 µs each: a tenth of a CPU. At a megabaud no more than
# 14,000 headers arrive per second. Only a network delivers more: those bytes are counted, and only their end
# is searched.
VAIN_LOOKS_PER_S = 20_000

# The most that a quiet line saves up: enough to find every frame in 64 KiB of headers alone.
MAX_SAVED_LOOKS = 10_000


@dataclass(slots=True)
class Frames:
    """The payloads of the frames of one topic id in one chunk, in order."""

    topic_id: int
    payloads: list[bytes]


Decoded: TypeAlias = Frames | FrameDiscarded


class FrameDecoder:
    """Cuts one direction of a line into frames of one protocol version; linear in what it is fed.

    `limits.possible` decides which unfinished frames are waited for; whole frames outside it are delivered.
    After `abandon_after_s` without a byte an unfinished frame is given up, whatever it holds (None: never).
    """

    def __init__(
        self,
        version: int = 2,
        *,
        max_payload_bytes: int = MAX_PAYLOAD_BYTES,
        limits: PayloadLimits = NO_LIMITS,
        abandon_after_s: float | None = None,
    ) -> None:
        self._version = version
        self._header_bytes = FORMS[version].header_bytes
        self._start = bytes((SYNC, FORMS[version].version_byte))
        self._scanner = FrameScanner(version, max_payload_bytes, limits.refused_above)
        self._possible = limits.possible
        self._abandon_after_s = abandon_after_s
        self._pending = bytearray()
        self._needed_bytes = 0
        self._fed_s = 0.0
        self._looks_left = float(MAX_SAVED_LOOKS)
        self._looks_counted_s = 0.0
        self._look_after_s = FIRST_LOOK_S
        self._look_at_s: float | None = None
        self._tail_look_after_s = FIRST_LOOK_S
        self._tail_look_at_s: float | None = None

    @property
    def version(self) -> int:
        """The protocol version it reads."""
        return self._version

    @property
    def pending_bytes(self) -> int:
        """How many bytes of an unfinished frame are kept."""
        return len(self._pending)

    @property
    def pending_header(self) -> Header | None:
        """The header of the incomplete frame, or None."""
        if len(self._pending) < self._header_bytes:
            return None
        return read_header(self._version, bytes(self._pending[: self._header_bytes]))

    def use_limits(self, limits: PayloadLimits) -> None:
        """Judge by these limits from the next frame on."""
        self._possible = limits.possible
        self._scanner.refuse_above(limits.refused_above)

    def is_receiving(self, topic_ids: Container[int], now_s: float) -> bool:
        """Whether a frame of one of these ids is just coming in."""
        header = self.pending_header
        return header is not None and header.topic_id in topic_ids and now_s < self._fed_s + RECEIVING_S

    def feed(self, data: bytes | bytearray | memoryview, now_s: float) -> list[Decoded]:
        """Handle a chunk, cut anywhere; return what it completes.

        First come the frames of reserved ids, in their order; then the messages, one group for each topic id;
        then the discarded bytes, in their order.
        """
        self._fed_s = now_s
        pending = self._pending
        if not pending:
            buffer = bytes(data)
            only = self._scanner.only_frame(buffer)
            if only is not None:
                topic_id, payload = only
                return [Frames(topic_id, [payload])]
            return self._accept(buffer, self._scan(buffer, Patience.WAIT, now_s), now_s)
        pending += data
        if len(pending) < self._needed_bytes:
            self._plan_look(now_s)
            return []
        buffer = bytes(pending)
        return self._accept(buffer, self._scan(buffer, Patience.WAIT, now_s), now_s)

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`."""
        timers = (self._look_at_s, self._tail_look_at_s, self._abandon_at_s())
        return min((timer for timer in timers if timer is not None), default=None)

    def handle_timer(self, now_s: float) -> list[Decoded]:
        """Look inside an unfinished frame that is due; return what it swallowed, if anything."""
        abandon_at_s = self._abandon_at_s()
        if abandon_at_s is not None and now_s >= abandon_at_s:
            return self.abandon(now_s)
        is_due = self._look_at_s is not None and now_s >= self._look_at_s
        is_tail_due = self._tail_look_at_s is not None and now_s >= self._tail_look_at_s
        if not (is_due or is_tail_due):
            return []
        buffer = bytes(self._pending)
        scan = self._scan(buffer, Patience.LOOK, now_s)
        found = {*scan.groups, *(topic_id for topic_id, _ in scan.controls)}
        swallowed = any(topic_id in self._possible for topic_id in found) if self._possible else found
        if swallowed and (is_due or scan.tail_frames >= TELLING_FRAMES):
            return self._accept(buffer, scan, now_s)
        if is_due:
            self._look_at_s = None
            self._look_after_s = min(2 * self._look_after_s, MAX_LOOK_S)
        if is_tail_due:
            self._tail_look_at_s = None
            self._tail_look_after_s = min(2 * self._tail_look_after_s, MAX_LOOK_S)
        return []

    def abandon(self, now_s: float) -> list[Decoded]:
        """Wait no longer for the unfinished frame; return what it holds."""
        buffer = bytes(self._pending)
        return self._accept(buffer, self._scan(buffer, Patience.NONE, now_s), now_s)

    def rescan(self, payload: bytes, now_s: float) -> list[Decoded]:
        """Return the frames inside a false payload; the bytes around them were reported before."""
        if self._start not in payload:
            return []
        scan = self._scan(payload, Patience.NONE, now_s)
        return _frames(scan)

    def _scan(self, buffer: bytes, patience: Patience, now_s: float) -> Scan:
        """Cut a buffer, at no greater cost than this line may cause."""
        saved = self._looks_left + (now_s - self._looks_counted_s) * VAIN_LOOKS_PER_S
        self._looks_left = min(max(saved, 0.0), MAX_SAVED_LOOKS)
        self._looks_counted_s = now_s
        scan = self._scanner.scan(buffer, patience, int(self._looks_left))
        self._looks_left -= scan.vain_looks
        return scan

    def _abandon_at_s(self) -> float | None:
        if self._abandon_after_s is None or not self._pending:
            return None
        return self._fed_s + self._abandon_after_s

    def _accept(self, buffer: bytes, scan: Scan, now_s: float) -> list[Decoded]:
        self._pending = bytearray(buffer[scan.rest :])
        self._needed_bytes = scan.needed_bytes
        self._look_after_s = self._tail_look_after_s = FIRST_LOOK_S
        self._look_at_s = self._tail_look_at_s = None
        if self._pending:
            self._plan_look(now_s)
        return [*_frames(scan), *scan.discarded]

    def _plan_look(self, now_s: float) -> None:
        header = self.pending_header
        if header is None:
            return
        is_possible = header.size <= self._possible.get(header.topic_id, -1)
        if self._look_at_s is None or is_possible:
            self._look_at_s = now_s + self._look_after_s
        if self._tail_look_at_s is None and is_possible:
            self._tail_look_at_s = now_s + self._tail_look_after_s


def _frames(scan: Scan) -> list[Decoded]:
    return [Frames(topic_id, payloads) for topic_id, payloads in (*scan.controls, *scan.groups.items())]
