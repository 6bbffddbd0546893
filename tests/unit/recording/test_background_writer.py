from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.recording.background_writer import BackgroundWriter
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.writer import BagWriter
from rostether.recording.recorded import Connection
from unit.recording.bags import START_NS, connection, text


class _Slow:
    """A writer that waits for `may_go`, and may fail."""

    def __init__(self, error: RecordingError | None = None) -> None:
        self.may_go = threading.Event()
        self.is_entered = threading.Event()
        self.flush_count = 0
        self.message_count = 0
        self.size_bytes = 0
        self._error = error

    def add_connection(self, connection: Connection) -> int:
        return 0

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        self.is_entered.set()
        assert self.may_go.wait(60)
        if self._error is not None:
            raise self._error
        self.message_count += len(payloads)

    def flush(self) -> None:
        self.flush_count += 1

    def close(self) -> None:
        return


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_all_written_messages_are_in_the_file(tmp_path: Path, compression: str) -> None:
    reported: list[str] = []
    inner = BagWriter(tmp_path / "a.bag", compression=compression, chunk_bytes=1000)
    writer = BackgroundWriter(inner, buffer_bytes=1 << 20, report=reported.append)
    numbers = [writer.add_connection(connection(topic)) for topic in ("/a", "/b")]
    for index in range(500):
        writer.write(numbers[index % 2], START_NS + index, [text(f"message {index}")])
        if index % 100 == 0:
            writer.flush()
    writer.close()
    writer.close()
    assert (writer.message_count, writer.lost_count, reported) == (500, 0, [])
    found = [(each.connection.topic, each.payload) for each in BagReader(tmp_path / "a.bag").messages()]
    assert found == [("/a" if index % 2 == 0 else "/b", text(f"message {index}")) for index in range(500)]


def test_messages_beyond_the_limit_are_lost_and_reported() -> None:
    reported: list[str] = []
    inner = _Slow()
    writer = BackgroundWriter(inner, buffer_bytes=1000, report=reported.append)
    number = writer.add_connection(connection())
    writer.write(number, 1, [b""])
    assert inner.is_entered.wait(60)
    writer.write(number, 2, [bytes(5000)])  # a single message may always wait
    writer.write(number, 3, [bytes(5)] * 3)
    writer.write(number, 4, [bytes(5)])
    reason = "data arrives faster than it can be compressed; choose a faster compression, or record less"
    assert reported == [f"lost 3 messages: {reason}"]
    inner.may_go.set()
    writer.close()
    assert (writer.message_count, writer.lost_count) == (2, 4)
    assert reported[1:] == [f"lost 4 messages: {reason}"]


def test_it_flushes_after_the_waiting_messages() -> None:
    inner = _Slow()
    writer = BackgroundWriter(inner, buffer_bytes=1 << 20, report=print)
    number = writer.add_connection(connection())
    writer.write(number, 1, [b""])
    writer.flush()
    writer.flush()
    writer.write(number, 2, [b""])
    inner.may_go.set()
    writer.close()
    assert (inner.message_count, inner.flush_count) == (2, 1)


def test_an_error_of_the_thread_is_raised_by_the_next_call() -> None:
    inner = _Slow(RecordingError("the disk is full"))
    inner.may_go.set()
    writer = BackgroundWriter(inner, buffer_bytes=1 << 20, report=print)
    writer.write(writer.add_connection(connection()), 1, [b""])
    with pytest.raises(RecordingError, match="the disk is full"):
        writer.close()
    writer.close()
