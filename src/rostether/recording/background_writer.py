"""Compresses and writes a recording in a thread, because bz2 takes a tenth of a second per chunk.

The compression libraries release the GIL. Only the queue is shared with the thread.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence

from rostether.errors import RecordingError
from rostether.mechanisms.text import counted
from rostether.recording.recorded import Connection, RecordingWriter

# The interval of warnings while compression is too slow.
REPORT_PERIOD_S = 5.0

# The approximate memory of a waiting message besides its payload.
_MESSAGE_BYTES = 100

# The number of a connection, the time in ns, the payloads, and their memory in bytes.
_Batch = tuple[int, int, Sequence[bytes], int]


class BackgroundWriter:
    """Passes all calls to another writer, in a thread; see `recording.recorded.RecordingWriter`.

    At most `buffer_bytes` wait; further messages are lost, and `report` gets a line. The next call raises an
    error of the other writer.
    """

    def __init__(
        self,
        writer: RecordingWriter,
        *,
        buffer_bytes: int,
        report: Callable[[str], None],
    ) -> None:
        self.lost_count = 0
        self._writer = writer
        self._buffer_bytes = buffer_bytes
        self._report = report
        self._reported_s = 0.0
        self._reported_count = 0
        self._numbers: dict[Connection, int] = {}
        self._connections: list[Connection] = []
        self._changed = threading.Condition()
        # Access everything below only while holding `_changed`.
        self._waiting: deque[_Batch] = deque()
        self._waiting_bytes = 0
        self._is_flushing = False
        self._is_ending = False
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._work, name="recording", daemon=True)
        self._thread.start()

    @property
    def size_bytes(self) -> int:
        """The size of the file and its open chunk, without the messages that still wait."""
        return self._writer.size_bytes

    @property
    def message_count(self) -> int:
        """How many messages were written."""
        return self._writer.message_count

    def add_connection(self, connection: Connection) -> int:
        """Add a connection if it is new; return its number. Equal connections share one."""
        number = self._numbers.get(connection)
        if number is None:
            number = self._numbers[connection] = len(self._connections)
            self._connections.append(connection)
        return number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Queue messages that arrived together, or drop them. Raises the error of an earlier write."""
        size_bytes = sum(map(len, payloads)) + _MESSAGE_BYTES * len(payloads)
        with self._changed:
            self._raise()
            # An empty queue accepts one batch of any size.
            is_accepted = not self._waiting or self._waiting_bytes + size_bytes <= self._buffer_bytes
            if is_accepted:
                self._waiting.append((number, time_ns, payloads, size_bytes))
                self._waiting_bytes += size_bytes
                self._changed.notify()
        if not is_accepted:
            self.lost_count += len(payloads)
            self._report_lost()

    def flush(self) -> None:
        """Write the open chunk in the thread, after the waiting messages. Raises RecordingError."""
        with self._changed:
            self._raise()
            self._is_flushing = True
            self._changed.notify()

    def wait_closed(self) -> None:
        """Wait until the file is complete and closed. Then `close` does not wait, but may raise an error."""
        with self._changed:
            self._is_ending = True
            self._changed.notify()
        self._thread.join()

    def close(self) -> None:
        """Wait until all is written, and close the file. Idempotent. Raises RecordingError."""
        self.wait_closed()
        if self.lost_count > self._reported_count:
            self._reported_s = 0.0
            self._report_lost()
        with self._changed:
            self._raise()

    def _raise(self) -> None:
        if self._error is not None:
            error, self._error = self._error, None
            raise error

    def _report_lost(self) -> None:
        now_s = time.monotonic()
        if now_s - self._reported_s >= REPORT_PERIOD_S:
            self._reported_s = now_s
            self._reported_count = self.lost_count
            self._report(
                f"lost {counted(self.lost_count, 'message')}: data arrives faster than it can be "
                "compressed; choose a faster compression, or record less"
            )

    def _work(self) -> None:
        numbers: dict[int, int] = {}
        is_broken = False
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._is_flushing or self._is_ending)
                batch = self._waiting.popleft() if self._waiting else None
                is_flushing = batch is None and self._is_flushing
                if is_flushing:
                    self._is_flushing = False
                is_ending = batch is None and not is_flushing
            try:
                if is_ending:
                    self._writer.close()
                elif is_flushing and not is_broken:
                    self._writer.flush()
                elif batch is not None and not is_broken:
                    number, time_ns, payloads, _ = batch
                    if number not in numbers:
                        numbers[number] = self._writer.add_connection(self._connections[number])
                    self._writer.write(numbers[number], time_ns, payloads)
            except Exception as error:  # noqa: BLE001 - reported in the recorder's thread
                is_broken = True
                with self._changed:
                    reason = str(error) or type(error).__name__
                    failure = error if isinstance(error, RecordingError) else RecordingError(reason)
                    self._error = self._error or failure
            if batch is not None:
                with self._changed:
                    self._waiting_bytes -= batch[3]
            if is_ending:
                return
