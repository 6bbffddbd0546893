"""Splits a byte stream into frames, and finds the frames inside an unfinished frame.

States and transitions:

    EMPTY    no bytes pending           -- bytes end within a frame -->       WAITING
    WAITING  an unfinished frame        -- its last byte arrives -->          EMPTY or WAITING (for the next)
                                        -- search due, frames inside -->      EMPTY or WAITING (it was noise)
                                        -- search due, no frames inside -->   WAITING, next search later

Noise may look like a header that claims 65535 bytes. A header that claims more than its topic allows is
refused immediately. The others are searched for frames inside them:

- If the topic and the length are possible, the search is due when no more bytes arrive. It is also due while
  bytes arrive. Then the frame is only rejected if it ends with several valid frames in a row: boards do not
  send those inside a message.
- If not, it is due soon after the frame began, even while bytes arrive.

A search destroys nothing: without a complete frame inside, the decoder waits for the rest, which a slow
network may still deliver.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import TypeAlias

from msgspec import Struct, field

from rostether.rosserial.events import FrameDiscarded
from rostether.rosserial.frame import FORMS, MAX_PAYLOAD_BYTES, SYNC, Header, read_header
from rostether.rosserial.frame_scan import FrameScanner, Patience, Scan

# Longer than pauses inside a frame on a working line (USB polls, operating system), usually below 20 ms.
FIRST_SEARCH_S = 0.1

# A frame that got no byte for this time is not being received.
RECEIVING_S = 0.05

# Searches become rarer, so that hostile input costs little; this limits the delay of the frames inside.
MAX_SEARCH_S = 1.0

# This number of valid frames in a row proves that the header before them is false: by chance, one frame in
# 65,536 is valid.
PROVING_FRAMES = 3

# Each position that looks like the start of a frame costs 2.5 to 6 µs, so this is a tenth of a CPU. A line at
# 1 Mbaud delivers at most 14,000 headers per second. A network may deliver more: then, only the end of the
# bytes is searched, and the rest is counted.
FALSE_STARTS_PER_S = 20_000

# How many of these positions a quiet line saves up: enough to find every frame in 64 KiB of headers.
MAX_SAVED_FALSE_STARTS = 10_000


class Frames(Struct):
    """The payloads of the frames of one topic id in one chunk, in order."""

    topic_id: int
    payloads: list[bytes]


Decoded: TypeAlias = Frames | FrameDiscarded


class PayloadLimits(Struct, frozen=True):
    """The longest possible payload of each topic id, and the length above which a header is noise.

    `refused_above` has the limit of all other ids under None.
    """

    possible: Mapping[int, int] = field(default_factory=dict)
    refused_above: Mapping[int | None, int] = field(default_factory=dict)


NO_LIMITS = PayloadLimits()


class FrameDecoder:
    """Splits one direction of a line into frames of one protocol version, in linear time.

    The decoder waits for unfinished frames within `limits.possible`; complete frames beyond it are delivered
    too. After `abandon_after_s` without a byte, any unfinished frame is rejected (None: never).
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
        self._false_starts_left = float(MAX_SAVED_FALSE_STARTS)
        self._false_starts_counted_s = 0.0
        self._search_after_s = FIRST_SEARCH_S
        self._search_at_s: float | None = None
        self._tail_search_after_s = FIRST_SEARCH_S
        self._tail_search_at_s: float | None = None

    @property
    def version(self) -> int:
        """The protocol version that it reads."""
        return self._version

    @property
    def pending_bytes(self) -> int:
        """The number of pending bytes of an unfinished frame."""
        return len(self._pending)

    @property
    def pending_header(self) -> Header | None:
        """The header of the unfinished frame, None if it is incomplete or there is none."""
        if len(self._pending) < self._header_bytes:
            return None
        return read_header(self._version, bytes(self._pending[: self._header_bytes]))

    def use_limits(self, limits: PayloadLimits) -> None:
        """Apply these limits, starting with the next frame."""
        self._possible = limits.possible
        self._scanner.refuse_above(limits.refused_above)

    def is_receiving(self, topic_ids: Container[int], now_s: float) -> bool:
        """Return whether a frame of one of these ids is being received."""
        header = self.pending_header
        return header is not None and header.topic_id in topic_ids and now_s < self._fed_s + RECEIVING_S

    def feed(self, data: bytes | bytearray | memoryview, now_s: float) -> list[Decoded]:
        """Handle a chunk, which may end anywhere; return the frames that it completes.

        First the frames of reserved ids, in their order; then the messages, one group for each topic id; then
        the discarded bytes, in their order.
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
            self._plan_search(now_s)
            return []
        buffer = bytes(pending)
        return self._accept(buffer, self._scan(buffer, Patience.WAIT, now_s), now_s)

    def get_timer(self) -> float | None:
        """Return when to call `handle_timer`, None if nothing is scheduled."""
        timers = (self._search_at_s, self._tail_search_at_s, self._abandon_at_s())
        return min((timer for timer in timers if timer is not None), default=None)

    def handle_timer(self, now_s: float) -> list[Decoded]:
        """Search the unfinished frame if a search is due; return the frames inside it."""
        abandon_at_s = self._abandon_at_s()
        if abandon_at_s is not None and now_s >= abandon_at_s:
            return self.abandon(now_s)
        is_due = self._search_at_s is not None and now_s >= self._search_at_s
        is_tail_due = self._tail_search_at_s is not None and now_s >= self._tail_search_at_s
        if not (is_due or is_tail_due):
            return []
        buffer = bytes(self._pending)
        scan = self._scan(buffer, Patience.SEARCH, now_s)
        found = {*scan.groups, *(topic_id for topic_id, _ in scan.controls)}
        has_frames = any(topic_id in self._possible for topic_id in found) if self._possible else found
        if has_frames and (is_due or scan.tail_frames >= PROVING_FRAMES):
            return self._accept(buffer, scan, now_s)
        if is_due:
            self._search_at_s = None
            self._search_after_s = min(2 * self._search_after_s, MAX_SEARCH_S)
        if is_tail_due:
            self._tail_search_at_s = None
            self._tail_search_after_s = min(2 * self._tail_search_after_s, MAX_SEARCH_S)
        return []

    def abandon(self, now_s: float) -> list[Decoded]:
        """Reject the unfinished frame; return the frames inside it."""
        buffer = bytes(self._pending)
        return self._accept(buffer, self._scan(buffer, Patience.NONE, now_s), now_s)

    def rescan(self, payload: bytes, now_s: float) -> list[Decoded]:
        """Return the frames inside a false payload; the bytes around them were reported before."""
        if self._start not in payload:
            return []
        return _frames(self._scan(payload, Patience.NONE, now_s))

    def _scan(self, buffer: bytes, patience: Patience, now_s: float) -> Scan:
        """Split a buffer into frames, within the cost that this line may cause."""
        saved = self._false_starts_left + (now_s - self._false_starts_counted_s) * FALSE_STARTS_PER_S
        self._false_starts_left = min(max(saved, 0.0), MAX_SAVED_FALSE_STARTS)
        self._false_starts_counted_s = now_s
        scan = self._scanner.scan(buffer, patience, int(self._false_starts_left))
        self._false_starts_left -= scan.false_starts
        return scan

    def _abandon_at_s(self) -> float | None:
        if self._abandon_after_s is None or not self._pending:
            return None
        return self._fed_s + self._abandon_after_s

    def _accept(self, buffer: bytes, scan: Scan, now_s: float) -> list[Decoded]:
        self._pending = bytearray(buffer[scan.rest :])
        self._needed_bytes = scan.needed_bytes
        self._search_after_s = self._tail_search_after_s = FIRST_SEARCH_S
        self._search_at_s = self._tail_search_at_s = None
        if self._pending:
            self._plan_search(now_s)
        return [*_frames(scan), *scan.discarded]

    def _plan_search(self, now_s: float) -> None:
        header = self.pending_header
        if header is None:
            return
        is_possible = header.size <= self._possible.get(header.topic_id, -1)
        if self._search_at_s is None or is_possible:
            self._search_at_s = now_s + self._search_after_s
        if self._tail_search_at_s is None and is_possible:
            self._tail_search_at_s = now_s + self._tail_search_after_s


def _frames(scan: Scan) -> list[Decoded]:
    return [Frames(topic_id, payloads) for topic_id, payloads in (*scan.controls, *scan.groups.items())]
