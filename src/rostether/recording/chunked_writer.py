"""The common part of the bag and MCAP writers: it collects messages in chunks.

A full or flushed chunk is written with one call, so a killed process leaves only complete chunks.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from array import array
from collections.abc import Callable, Iterable, Sequence
from itertools import accumulate, chain
from pathlib import Path

from rostether.errors import RecordingError
from rostether.mechanisms.text import write_failure
from rostether.recording.compression import check_compression, compress
from rostether.recording.write_errors import writing

# The size that rosbag uses: it compresses well, and one message is still quick to read.
DEFAULT_CHUNK_BYTES = 768 * 1024


class ChunkedWriter(ABC):
    """The base of the bag and MCAP writers; see `recording.recorded.RecordingWriter`.

    `_index` has an array for each connection, with a row for each message: the columns of its time, and its
    offset in the chunk. Raises RecordingError, and ConfigError if the compression is unknown or not
    installed.
    """

    # The type code of the index for `array`.
    _index_code: str

    def __init__(self, path: Path, compression: str, chunk_bytes: int, file_head: bytes) -> None:
        check_compression(compression)
        self.path = path
        self.message_count = 0
        self._compression = compression
        self._limit_bytes = chunk_bytes
        self._is_closed = False
        self._parts: list[bytes] = []
        self._chunk_bytes = 0
        self._index: dict[int, array[int]] = {}
        self._start_ns: int | None = None
        self._end_ns = 0
        self._is_sorted = True
        self._file = OutputFile(path)
        try:
            self._append(file_head)
        except RecordingError:
            self._is_closed = True
            self._file.close()
            raise

    @property
    def size_bytes(self) -> int:
        """The size of the file and of the data that waits to be written."""
        return self._file.position + self._chunk_bytes

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Write messages that arrived at the same time. Raises RecordingError if the disk rejects them."""
        if not payloads:
            return
        index = self._index.get(number)
        if index is None:
            index = self._index[number] = array(self._index_code)
            for record in self._pop_unwritten(number):
                self._parts.append(record)
                self._chunk_bytes += len(record)
        time_columns, head_of = self._message_form(number, time_ns)
        sizes = [len(each) for each in payloads]
        offsets: Sequence[int]
        if sizes.count(sizes[0]) == len(sizes):
            # The usual case, many messages of one size: no Python loop per message.
            head = head_of(sizes[0])
            step = len(head) + sizes[0]
            end = self._chunk_bytes + step * len(sizes)
            offsets = range(self._chunk_bytes, end, step)
            self._parts.append(head + head.join(payloads))
        else:
            heads = [head_of(size) for size in sizes]
            head_bytes = len(heads[0])
            steps = (head_bytes + size for size in sizes)
            *offsets, end = accumulate(steps, initial=self._chunk_bytes)
            self._parts.extend(chain.from_iterable(zip(heads, payloads, strict=True)))
        self._chunk_bytes = end
        rows = array(self._index_code, (*time_columns, 0)) * len(sizes)
        rows[len(time_columns) :: len(time_columns) + 1] = array(self._index_code, offsets)
        index.extend(rows)
        self._is_sorted = self._is_sorted and time_ns >= self._end_ns
        self._start_ns = time_ns if self._start_ns is None else min(self._start_ns, time_ns)
        self._end_ns = max(self._end_ns, time_ns)
        self.message_count += len(payloads)
        if self._chunk_bytes >= self._limit_bytes:
            self.flush()

    def flush(self) -> None:
        """End the chunk and write it. Raises RecordingError; the file then ends with the previous chunk."""
        if self._start_ns is not None:
            plain = b"".join(self._parts)
            self._write_chunk(plain, compress(self._compression, plain), self._start_ns)

    def close(self) -> None:
        """Write the index and close the file. Idempotent. Raises RecordingError; the chunks are kept."""
        if self._is_closed:
            return
        self._is_closed = True
        try:
            try:
                self.flush()
            finally:
                self._write_end()
        finally:
            self._file.close()

    @abstractmethod
    def _pop_unwritten(self, number: int) -> Iterable[bytes]:
        """Return the records that must precede the first message of a connection in a chunk."""

    @abstractmethod
    def _message_form(self, number: int, time_ns: int) -> tuple[tuple[int, ...], Callable[[int], bytes]]:
        """Return a time as index columns, and a function that returns a message's header for its size.

        All headers have the same length.
        """

    @abstractmethod
    def _write_chunk(self, plain: bytes, stored: bytes, start_ns: int) -> None:
        """Write the open chunk, which is compressed to `stored`, and its indexes with `_append_chunk`."""

    @abstractmethod
    def _write_end(self) -> None:
        """Write the part after the last chunk."""

    def _append(self, data: bytes) -> None:
        self._file.append(data)

    def _append_chunk(self, data: bytes, message_count: int) -> None:
        """Write a chunk and begin the next one; the messages of a chunk that is not written do not count."""
        self._parts = []
        self._chunk_bytes = 0
        self._index = {}
        self._start_ns = None
        self._end_ns = 0
        self._is_sorted = True
        try:
            self._append(data)
        except RecordingError:
            self.message_count -= message_count
            raise


class OutputFile:
    """Appends to a file, which it creates or empties; `position` is the end of the last complete part.

    Raises RecordingError if the file cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.position = 0
        flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
        with writing(path):
            self._file: int | None = os.open(path, flags, 0o666)

    def append(self, data: bytes) -> None:
        """Write a complete part, or restore the file and raise RecordingError."""
        try:
            self._write(data)
        except OSError as error:
            self._cut()
            raise RecordingError(write_failure(self.path, error)) from None
        self.position += len(data)

    def replace(self, position: int, data: bytes) -> None:
        """Overwrite existing bytes. Raises RecordingError."""
        assert self._file is not None
        with writing(self.path):
            os.lseek(self._file, position, os.SEEK_SET)
            self._write(data)
            os.lseek(self._file, self.position, os.SEEK_SET)

    def close(self) -> None:
        """Close the file. Idempotent."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _write(self, data: bytes) -> None:
        assert self._file is not None
        view = memoryview(data)
        while view:
            view = view[os.write(self._file, view) :]

    def _cut(self) -> None:
        assert self._file is not None
        try:
            os.ftruncate(self._file, self.position)
            os.lseek(self._file, self.position, os.SEEK_SET)
        except OSError:
            # Devices cannot be truncated; readers find the last complete part themselves.
            return
