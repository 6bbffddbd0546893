"""Scans a buffer in one pass: finds its frames, other bytes, and the start of an unfinished frame.

Usually, many frames with the same header (same topic, same length) follow each other. Then the header is
checked once, and `struct.iter_unpack` cuts the whole run at C speed. A known header costs one dictionary
lookup.

Other bytes are reported in stretches. A stretch begins where a check fails, and ends where a frame may begin.
So every byte of the buffer is in exactly one frame, one stretch or the unfinished rest. After a failed check,
the search continues at the byte after the sync, because noise may contain a valid header.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum, auto
from functools import lru_cache
from struct import Struct
from typing import NamedTuple
from zlib import adler32

import msgspec
from msgspec import field

from rostether.rosserial.checksum import RunningSums, sum_function
from rostether.rosserial.events import DiscardReason, FrameDiscarded
from rostether.rosserial.frame import FORMS, SYNC
from rostether.rosserial.topic_id import FIRST_USER_ID

# Stretches between two valid frames. Each is one event, and noise must not cause any number of them: the last
# stretch includes all further ones.
MAX_STRETCHES = 64

# Checksumming a false frame costs as much as one header check per this many bytes.
FALSE_START_SUMS_BYTES = 4096
FALSE_START_RUNNING_SUMS_BYTES = 64

# If a buffer is too noisy to scan completely, its end is scanned: it has the newest data of the device.
MIN_TAIL_BYTES = 256
MAX_TAIL_BYTES = 1024
TAIL_DIVISOR = 64

# A few dozen topics times the lengths of their strings; when the table is full, all headers are forgotten.
MAX_KNOWN_HEADERS = 1024

_SYNC = bytes((SYNC,))
_VERSION = DiscardReason.VERSION
_JOINABLE = (DiscardReason.NOISE, DiscardReason.VERSION)


class Patience(Enum):
    """How to handle a frame whose end is not in the buffer."""

    # Wait for its end, without a search in the bytes after it.
    WAIT = auto()
    # Search the bytes after it: if a valid frame follows, it was noise; else wait for its end.
    SEARCH = auto()
    # It is noise; there is no rest.
    NONE = auto()


class _KnownHeader(NamedTuple):
    """A valid header, with the values to cut and check frames that begin with it."""

    topic_id: int
    stride: int
    sum_of: Callable[[bytes], int]
    target: int


class Scan(msgspec.Struct):
    """The content of a buffer. At `rest`, an unfinished frame of `needed_bytes` begins.

    `controls` are the frames of reserved ids in their order, `groups` all others by id.
    The last `tail_frames` frames follow each other without other bytes between them. `false_starts` counts
    the positions where a frame might have begun, but did not.
    """

    controls: list[tuple[int, list[bytes]]] = field(default_factory=list)
    groups: dict[int, list[bytes]] = field(default_factory=dict)
    discarded: list[FrameDiscarded] = field(default_factory=list)
    rest: int = 0
    needed_bytes: int = 0
    tail_frames: int = 0
    false_starts: int = 0

    def add(self, topic_id: int, payloads: list[bytes]) -> None:
        """Add the first frames of a topic, or frames of a reserved id."""
        if topic_id < FIRST_USER_ID:
            self.controls.append((topic_id, payloads))
        else:
            self.groups[topic_id] = payloads


class FrameScanner:
    """Finds the frames of one protocol version, remembering headers from buffer to buffer.

    A header that claims more than the limit of its topic id in `refused_above` is not a frame. The limit of
    other ids is under None.
    """

    def __init__(self, version: int, max_payload_bytes: int, refused_above: Mapping[int | None, int]) -> None:
        self._version = version
        self._version_byte, self._header_bytes, self._overhead_bytes = FORMS[version]
        self._start = bytes((SYNC, self._version_byte))
        self._max_payload_bytes = max_payload_bytes
        self._refused_above = refused_above
        self._known: dict[bytes, _KnownHeader] = {}

    def refuse_above(self, refused_above: Mapping[int | None, int]) -> None:
        """Apply these limits from now on, even to known headers."""
        self._refused_above = refused_above
        self._known.clear()

    def only_frame(self, buffer: bytes) -> tuple[int, bytes] | None:
        """Return topic id and payload if the buffer is one valid frame with a known header, else None.

        It takes a quarter of the time of a scan, for boards that send one message at a time.
        """
        known = self._known.get(buffer[: self._header_bytes])
        if known is None or known.stride != len(buffer):
            return None
        payload = buffer[self._header_bytes : -1]
        if (known.sum_of(payload) + buffer[-1]) & 0xFF != known.target:
            return None
        return known.topic_id, payload

    def scan(self, buffer: bytes, patience: Patience, max_false_starts: int) -> Scan:
        """Split a buffer that begins where a frame may begin.

        After more than `max_false_starts`, only its end is searched; the rest is noise.
        """
        result = Scan()
        discarded = _DiscardedStretches(buffer, self._start, max_false_starts)
        unfinished = self._cut_frames(buffer, patience, result, discarded)
        result.rest = len(buffer)
        if unfinished is not None and patience is not Patience.NONE:
            result.rest, result.needed_bytes = unfinished
        if discarded.false_starts:
            result.false_starts = discarded.false_starts
            result.discarded = discarded.pieces(result.rest)
        return result

    def _cut_frames(  # noqa: PLR0915 - the hot loop: a call costs as much as a small frame
        self, buffer: bytes, patience: Patience, result: Scan, discarded: _DiscardedStretches
    ) -> tuple[int, int] | None:
        """Add the valid frames to the result, and return position and size of an unfinished one, if any."""
        groups = result.groups
        known_headers = self._known
        header_bytes = self._header_bytes
        total = len(buffer)
        sums: RunningSums | None = None
        unfinished: tuple[int, int] | None = None
        tail_frames = 0
        position = 0
        header = buffer[:header_bytes]
        while header:
            known = known_headers.get(header)
            if known is None:
                verdict = self._check_header(header)
                if isinstance(verdict, DiscardReason):
                    position = discarded.reject(position, verdict)
                    header = buffer[position : position + header_bytes]
                    continue
                known = verdict
            topic_id, stride, sum_of, target = known
            end = position + stride
            if end > total:
                unfinished = unfinished or (position, stride)
                if patience is Patience.WAIT:
                    break
                position = discarded.reject(position, DiscardReason.UNFINISHED)
                header = buffer[position : position + header_bytes]
                continue
            following = buffer[end : end + header_bytes]
            if sums is not None:
                is_valid = sums.one_plus_sum(position + header_bytes, end) & 0xFF == target
                good = [buffer[position + header_bytes : end - 1]] if is_valid else []
            elif following == header:
                good = _split_run(buffer, position, header, known)
                end = position + len(good) * stride
                following = buffer[end : end + header_bytes]
            else:
                payload = buffer[position + header_bytes : end - 1]
                good = [payload] if (sum_of(payload) + buffer[end - 1]) & 0xFF == target else []
            if not good:
                position = discarded.reject_payload(position, stride)
                header = buffer[position : position + header_bytes]
                sums = sums or discarded.sums_after(stride)
                continue
            if discarded.is_open:
                discarded.end(position)
                tail_frames = 0
            tail_frames += len(good)
            unfinished = None
            group = groups.get(topic_id)
            if group is not None:
                group += good
            else:
                result.add(topic_id, good)
            position = end
            header = following
        result.tail_frames = tail_frames
        return unfinished

    def _check_header(self, header: bytes) -> _KnownHeader | DiscardReason:
        """Check an unknown header; an incomplete one becomes a frame longer than the buffer."""
        size = len(header)
        if header[0] != SYNC:
            return DiscardReason.NOISE
        if size > 1 and header[1] != self._version_byte:
            return DiscardReason.VERSION
        if self._version == 2 and size >= 5:  # the length checksum is before the topic id
            if (header[2] + header[3] + header[4]) & 0xFF != 0xFF:
                return DiscardReason.LENGTH_CHECKSUM
            length = header[2] | header[3] << 8
            if length > self._max_payload_bytes:
                return DiscardReason.TOO_LONG
            # Only complete headers continue here; noise is refused at half the cost.
            if size == self._header_bytes:
                return self._remember(header, header[5] | header[6] << 8, length, header[5] + header[6])
        if size < self._header_bytes:
            return _KnownHeader(-1, size + 1, adler32, 0)
        length = header[4] | header[5] << 8
        return self._remember(header, header[2] | header[3] << 8, length, sum(header[2:]))

    def _remember(self, header: bytes, topic_id: int, length: int, base: int) -> _KnownHeader | DiscardReason:
        """Check the length of a valid header; `base` is the header's part of the payload checksum."""
        if length > self._max_length(topic_id) or length > self._max_payload_bytes:
            return DiscardReason.TOO_LONG
        if len(self._known) >= MAX_KNOWN_HEADERS:
            self._known.clear()
        known = _KnownHeader(topic_id, length + self._overhead_bytes, sum_function(length), -base & 0xFF)
        self._known[header] = known
        return known

    def _max_length(self, topic_id: int) -> int:
        """Return the longest payload that a frame on this id may have."""
        limit = self._refused_above.get(topic_id)
        return self._refused_above.get(None, self._max_payload_bytes) if limit is None else limit


@lru_cache(maxsize=MAX_KNOWN_HEADERS)
def _run_layout(header_bytes: int, stride: int) -> Struct:
    """Return a struct that splits a run of frames; headers in noise mostly occur once, and need none."""
    return Struct(f"{header_bytes}s{stride - header_bytes - 1}sB")


def _split_run(buffer: bytes, position: int, header: bytes, known: _KnownHeader) -> list[bytes]:
    """Return the payloads of the valid frames, all with the same header, that begin at a position."""
    _, stride, sum_of, target = known
    run = memoryview(buffer)[position : len(buffer) - (len(buffer) - position) % stride]
    good: list[bytes] = []
    for head, payload, check in _run_layout(len(header), stride).iter_unpack(run):
        if head != header or (sum_of(payload) + check) & 0xFF != target:
            break
        good.append(payload)
    return good


class _DiscardedStretches:
    """The stretches between the frames of a buffer, as [start, end, reason], and the cost of the search.

    After more than `max_false_starts` positions without a frame, only the end of the buffer is searched.
    """

    __slots__ = (
        "_buffer",
        "_count",
        "_frame_start",
        "_max_false_starts",
        "_reason",
        "_start",
        "_stretches",
        "_total",
        "_wasted_bytes",
        "false_starts",
        "is_open",
    )

    def __init__(self, buffer: bytes, start: bytes, max_false_starts: int) -> None:
        self.is_open = False
        self.false_starts = 0
        self._buffer = buffer
        self._total = len(buffer)
        self._frame_start = start
        self._max_false_starts = max_false_starts
        self._wasted_bytes = 0
        self._stretches: list[tuple[int, int, DiscardReason]] = []
        self._start = 0
        self._reason = DiscardReason.NOISE
        self._count = 0

    def reject(self, position: int, reason: DiscardReason, false_starts: int = 1) -> int:
        """Begin a stretch where a check failed, and return where a frame may begin next."""
        if not self.is_open:
            self.is_open = True
            self._start = position
            self._reason = reason
        elif self._count < MAX_STRETCHES and (reason is not self._reason or reason not in _JOINABLE):
            self._stretches.append((self._start, position, self._reason))
            self._count += 1
            self._start = position
            self._reason = reason
        self.false_starts += false_starts
        if self.false_starts > self._max_false_starts:
            position = self._skip(position)
        wanted = self._frame_start if reason is _VERSION else _SYNC
        found = self._buffer.find(wanted, position + 1)
        return found if found >= 0 else self._last_start(position + 1, wanted)

    def reject_payload(self, position: int, stride: int) -> int:
        """Reject a frame whose payload failed its check; a longer payload counts as more false starts."""
        false_starts = 1 + stride // FALSE_START_SUMS_BYTES
        return self.reject(position, DiscardReason.PAYLOAD_CHECKSUM, false_starts)

    def sums_after(self, stride: int) -> RunningSums | None:
        """Count the summed bytes of a false frame; return cheaper sums once they are too many, else None."""
        self._wasted_bytes += stride
        if self._wasted_bytes <= 2 * self._total:
            return None
        self.false_starts += self._total // FALSE_START_RUNNING_SUMS_BYTES
        return RunningSums(self._buffer)

    def end(self, position: int) -> None:
        """End the stretch that is open: a frame begins here."""
        self._stretches.append((self._start, position, self._reason))
        self.is_open = False
        self._count = 0

    def pieces(self, rest: int) -> list[FrameDiscarded]:
        """Return the stretches with their bytes, as far as they are before the unfinished rest."""
        if self.is_open:
            self.end(self._total)
        return [
            FrameDiscarded(reason, self._buffer[start : min(end, rest)])
            for start, end, reason in self._stretches
            if start < rest
        ]

    def _skip(self, position: int) -> int:
        """Extend this stretch to the last part of the buffer, and return where that part begins."""
        self._count = MAX_STRETCHES
        self._max_false_starts = self._total
        tail_bytes = max(MIN_TAIL_BYTES, min(self._total // TAIL_DIVISOR, MAX_TAIL_BYTES))
        return max(position, self._total - tail_bytes)

    def _last_start(self, position: int, wanted: bytes) -> int:
        """Return the end of the buffer, or its last byte if a frame may begin there."""
        return self._total - 1 if position < self._total and self._buffer[-1] == wanted[0] else self._total
