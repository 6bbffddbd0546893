"""Messages longer than the board announced: each is refused at its header, and its rest is discarded."""

from __future__ import annotations

from collections import OrderedDict

from msgspec import Struct

from rostether.rosserial.events import DiscardReason, FrameDiscarded
from rostether.rosserial.frame import FORMS, read_header

# One in 256 damaged headers passes its check, but hardly three with the same topic id.
MIN_COUNT = 3

# After a while, a corrected problem is no longer reported.
RECENT_S = 30.0

# At 9600 baud, the rest of a frame arrives within this time, a few bytes at a time.
REST_GAP_S = 0.1

# More than any board has room for; limits the memory for a device that uses new ids all the time.
MAX_IDS = 64


class Oversize(Struct):
    """The dropped messages of one topic id; `largest_bytes` is the largest payload."""

    count: int = 0
    largest_bytes: int = 0
    last_s: float = 0.0


class Oversizes:
    """The refused lengths of one connection, by topic id."""

    def __init__(self) -> None:
        self._found: OrderedDict[int, Oversize] = OrderedDict()
        self._cut = b""
        self._rest_bytes = 0
        self._piece_s = 0.0

    def handle_discarded(self, event: FrameDiscarded, version: int | None, now_s: float) -> bool:
        """Handle discarded bytes; return whether they belong to a message that was too long."""
        if event.reason is DiscardReason.TOO_LONG:
            self._cut = b""
            self._note(event.data, version, now_s)
            return True
        if self._cut:
            # A byte of the header looked like the beginning of another one.
            self._note(self._cut + event.data, version, now_s)
            return True
        if self._rest_bytes <= 0 or now_s - self._piece_s > REST_GAP_S:
            return False
        self._piece_s = now_s
        self._rest_bytes -= len(event.data)
        return True

    def of(self, topic_id: int, now_s: float) -> Oversize | None:
        """Return the recent oversized messages of a topic id, None if there are fewer than `MIN_COUNT`."""
        found = self._found.get(topic_id)
        if found is None or found.count < MIN_COUNT or now_s - found.last_s > RECENT_S:
            return None
        return found

    def _note(self, data: bytes, version: int | None, now_s: float) -> None:
        form = FORMS.get(version or 0)
        if form is None:
            return
        self._piece_s = now_s
        self._cut = data if len(data) < form.header_bytes else b""
        if self._cut:
            return
        header = read_header(version or 0, data[: form.header_bytes])
        if header is None:
            return
        self._rest_bytes = header.size + form.overhead_bytes - len(data)
        found = self._found.setdefault(header.topic_id, Oversize())
        self._found.move_to_end(header.topic_id)
        if now_s - found.last_s > RECENT_S:
            found.count = found.largest_bytes = 0
        found.count += 1
        found.largest_bytes = max(found.largest_bytes, header.size)
        found.last_s = now_s
        while len(self._found) > MAX_IDS:
            self._found.popitem(last=False)
