from __future__ import annotations

import errno
import os
import struct
from pathlib import Path
from typing import Any

import pytest

from rostether.errors import RecordingError
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.records import Op, op_of, read_record, time_field
from rostether.recording.bag.writer import BagWriter
from rostether.recording.mcap.reader import McapReader
from rostether.recording.mcap.writer import McapWriter
from rostether.recording.recorded import Connection
from rostether.rostime import NS_PER_S
from unit.recording.bags import START_NS, STRING, connection, text, write_bag, write_reset


def test_batches_with_one_size_or_several_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    writer = BagWriter(path)
    number = writer.add_connection(connection())
    batches = [[text("abc")] * 5, [text("x" * size) for size in range(7)], [b""], []]
    for index, batch in enumerate(batches):
        writer.write(number, START_NS + index, batch)
    writer.close()
    found = [(message.time_ns, message.payload) for message in BagReader(path).messages()]
    assert found == [(START_NS + index, each) for index, batch in enumerate(batches) for each in batch]


def test_equal_connections_share_a_number(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / "a.bag")
    assert writer.add_connection(connection()) == writer.add_connection(connection())
    assert writer.add_connection(connection()) != writer.add_connection(connection(caller="/other"))
    writer.close()


def test_flushed_messages_are_complete_in_a_bag_that_was_not_closed(tmp_path: Path) -> None:
    written = write_bag(tmp_path / "a.bag", closes=False)
    reader = BagReader(tmp_path / "a.bag")
    assert "not closed" in reader.damage
    assert [(each.connection.topic, each.time_ns, each.payload) for each in reader.messages()] == written


def test_an_empty_bag_can_be_read(tmp_path: Path) -> None:
    BagWriter(tmp_path / "a.bag").close()
    reader = BagReader(tmp_path / "a.bag")
    assert (reader.span_ns, list(reader.messages()), reader.damage) == (None, [], "")


def test_a_full_disk_keeps_the_earlier_chunks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.bag"
    limit = 8000
    real_write = os.write

    def write(file: int, data: Any) -> int:
        room = limit - os.lseek(file, 0, os.SEEK_CUR)
        if room <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real_write(file, bytes(data)[:room])

    monkeypatch.setattr("rostether.recording.chunked_writer.os.write", write)
    writer = BagWriter(path, chunk_bytes=500)
    number = writer.add_connection(connection())
    taken = 0
    with pytest.raises(RecordingError, match="No space left"):
        while True:
            writer.write(number, START_NS + taken, [text("x" * 100)])
            taken += 1
    kept = writer.message_count
    # The truncated chunk has left room for the index, or the file has none.
    try:
        writer.close()
    except RecordingError:
        assert BagReader(path).damage
    reader = BagReader(path)
    found = [message.time_ns for message in reader.messages()]
    assert found == [START_NS + index for index in range(kept)]
    assert 0 < kept <= taken


def test_a_missing_folder_is_reported(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="No such file"):
        BagWriter(tmp_path / "none" / "a.bag")


def test_a_device_that_is_full_from_the_start_is_reported() -> None:
    with pytest.raises(RecordingError, match="No space left"):
        BagWriter(Path("/dev/full"))


def test_the_first_chunk_has_the_position_that_rosbag_expects(tmp_path: Path) -> None:
    # rosbag's reindex overwrites the header: if it were shorter, the next chunk would be lost.
    write_bag(tmp_path / "a.bag")
    data = (tmp_path / "a.bag").read_bytes()
    assert data.index(b"compression=none") == 4117 + 8


def test_connection_headers_are_the_same_in_both_formats(tmp_path: Path) -> None:
    output = {
        "callerid": "/talker",
        "latching": "0",
        "md5sum": STRING.md5sum,
        "message_definition": STRING.definition,
        "topic": "/chatter",
        "type": STRING.name,
        "vendor": "acme",
    }
    reported = Connection.from_fields("/chatter", output)
    assert not reported.is_latching
    for name, create, read in (("a.bag", BagWriter, BagReader), ("a.mcap", McapWriter, McapReader)):
        writer = create(tmp_path / name)
        writer.write(writer.add_connection(reported), START_NS, [text("one")])
        writer.close()
        reader = read(tmp_path / name)
        (reported,) = reader.counts
        reader.close()
    assert list(reported.fields().items()) == list(output.items())


@pytest.mark.parametrize("chunk_bytes", [300, 100_000])
def test_indexes_are_sorted_by_time(tmp_path: Path, chunk_bytes: int) -> None:
    # Debian's rosbag uses the start of the first chunk and the end of the last one for the bag, and bisects.
    write_reset(BagWriter(tmp_path / "a.bag", chunk_bytes=chunk_bytes))
    data = (tmp_path / "a.bag").read_bytes()
    starts, position = [], 13
    while position < len(data):
        fields, start, position = read_record(data, position)
        if op_of(fields) == Op.INDEX:
            times = [secs for secs, _, _ in struct.iter_unpack("<III", data[start:position])]
            assert times == sorted(times)
        elif op_of(fields) == Op.CHUNK_INFO:
            starts.append(time_field(fields, b"start_time"))
    assert starts == sorted(starts)
    assert starts[0] == NS_PER_S
