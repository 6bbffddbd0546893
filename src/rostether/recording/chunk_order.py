"""Merges the messages of chunks by time, in bounded memory, even if the index of a chunk is wrong.

Chunks may overlap in time. A chunk is opened at the time of its first message, and its messages are merged
with those of the other open chunks. Open chunks that need too much memory are closed, and
opened again when their next message is due.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import islice, pairwise

from rostether.recording.compression import MAX_LISTED_BYTES, NONE, StoredChunk

# The memory limit of open chunks; files in time order need one or a few at a time.
MAX_OPEN_BYTES = 256 << 20

# The memory of a listed message: a tuple of four numbers.
_ENTRY_BYTES = 220

# Time in ns, start and end of the payload in the uncompressed chunk, and the connection's number.
Entry = tuple[int, int, int, int]

# A chunk's data, and a function that returns an iterator over its messages in file order.
Unpacked = tuple[bytes | memoryview, Callable[[], Iterator[Entry]]]


def in_order(
    chunks: Sequence[StoredChunk],
    unpack: Callable[[StoredChunk], Unpacked],
    *,
    start_ns: int | None = None,
    end_ns: int | None = None,
) -> Iterator[tuple[int, int, bytes]]:
    """Yield (connection number, time in ns, payload) by time, both ends included; equal times in file order.

    `chunks` are sorted by the times of their first messages. Raises the errors of `unpack` and its iterator.
    """
    heap: list[tuple[int, int, _ChunkCursor]] = []
    opened: dict[int, _ChunkCursor] = {}
    open_bytes = 0
    following = 0
    min_ns, max_ns = -1 if start_ns is None else start_ns, 1 << 64 if end_ns is None else end_ns
    while True:
        while following < len(chunks) and (not heap or chunks[following].start_ns <= heap[0][0]):
            chunk = _ChunkCursor(chunks[following], unpack, min_ns, max_ns)
            if chunk.advance():
                heappush(heap, (chunk.time_ns, following, chunk))
                opened[following] = chunk
                open_bytes += chunk.held_bytes
                if open_bytes > MAX_OPEN_BYTES:
                    open_bytes -= _close_except(opened, heap[0][1])
            following += 1
        if not heap:
            return
        _, rank, chunk = heappop(heap)
        if rank not in opened:
            opened[rank] = chunk
            open_bytes += chunk.held_bytes
            if open_bytes > MAX_OPEN_BYTES:
                open_bytes -= _close_except(opened, rank)
        until_ns = heap[0][0] if heap else 1 << 64
        if following < len(chunks):
            until_ns = min(until_ns, chunks[following].start_ns)
        yield chunk.current_message()
        while chunk.advance():
            # No other chunk has a message before this time, so the heap is not needed.
            if chunk.time_ns >= until_ns:
                heappush(heap, (chunk.time_ns, rank, chunk))
                break
            yield chunk.current_message()
        else:
            del opened[rank]
            open_bytes -= chunk.held_bytes


def _close_except(opened: dict[int, _ChunkCursor], kept: int) -> int:
    """Close all chunks except one; return the number of bytes freed."""
    freed = 0
    for rank in [each for each in opened if each != kept]:
        chunk = opened.pop(rank)
        chunk.close()
        freed += chunk.held_bytes
    return freed


class _ChunkCursor:
    """A cursor over the messages of a chunk; `time_ns` is the time of the current one."""

    def __init__(
        self, chunk: StoredChunk, unpack: Callable[[StoredChunk], Unpacked], min_ns: int, max_ns: int
    ) -> None:
        self._chunk = chunk
        self._unpack = unpack
        self._min_ns = min_ns
        self._max_ns = max_ns
        self._passed = 0
        self._plain: bytes | memoryview | None = None
        self._items: Iterator[Entry] | None = None
        self._entry: Entry = (0, 0, 0, 0)
        self.held_bytes = 0
        self._open()

    @property
    def time_ns(self) -> int:
        return self._entry[0]

    def advance(self) -> bool:
        """Go to the next message; False at the end."""
        if self._items is None:
            self._open()
        assert self._items is not None
        entry = next(self._items, None)
        if entry is None:
            self.close()
            return False
        self._entry = entry
        self._passed += 1
        return True

    def current_message(self) -> tuple[int, int, bytes]:
        """Return connection number, time and payload of the current message."""
        if self._plain is None:
            self._open()
        assert self._plain is not None
        time_ns, start, end, number = self._entry
        return number, time_ns, bytes(self._plain[start:end])

    def close(self) -> None:
        """Release the memory of the chunk until the next access."""
        self._items = self._plain = None

    def _open(self) -> None:
        self._plain, walk = self._unpack(self._chunk)
        min_ns, max_ns = self._min_ns, self._max_ns
        entries: Iterable[Entry]
        self.held_bytes = 0
        if self._chunk.size_bytes <= MAX_LISTED_BYTES:
            listed = [entry for entry in walk() if min_ns <= entry[0] <= max_ns]
            listed.sort()
            entries = listed
            self.held_bytes = len(listed) * _ENTRY_BYTES
        elif _is_in_order(walk()):
            entries = (entry for entry in walk() if min_ns <= entry[0] <= max_ns)
        else:
            entries = (entry for entry in _sorted(walk()) if min_ns <= entry[0] <= max_ns)
        if self._chunk.compression not in ("", NONE):
            self.held_bytes += self._chunk.size_bytes
        self._items = islice(entries, self._passed, None)


def _is_in_order(entries: Iterable[Entry]) -> bool:
    return all(earlier[0] <= later[0] for earlier, later in pairwise(entries))


def _sorted(entries: Iterable[Entry]) -> Iterator[Entry]:
    """Yield entries by time, with a fifth of the memory of a list."""
    columns = (array("Q"), array("Q"), array("Q"), array("Q"))
    for entry in entries:
        for column, value in zip(columns, entry, strict=True):
            column.append(value)
    for index in sorted(range(len(columns[0])), key=columns[0].__getitem__):
        time_ns, start, end, number = (column[index] for column in columns)
        yield time_ns, start, end, number
