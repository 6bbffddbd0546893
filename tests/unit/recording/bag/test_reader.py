from __future__ import annotations

import struct
from pathlib import Path

import pytest

from rostether.errors import RecordingError
from rostether.recording.bag.reader import BagReader
from rostether.recording.bag.records import (
    MAGIC,
    U32,
    Op,
    bag_header,
    encode_fields,
    encode_record,
    encode_time,
)
from rostether.recording.bag.writer import BagWriter
from unit.recording.bags import START_NS, connection, text, write_bag


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_written_messages_are_read(tmp_path: Path, compression: str) -> None:
    written = write_bag(tmp_path / "a.bag", compression=compression)
    reader = BagReader(tmp_path / "a.bag")
    assert [(each.connection.topic, each.time_ns, each.payload) for each in reader.messages()] == written
    assert {each.topic: count for each, count in reader.counts.items()} == {"/a": 15, "/b": 15}
    assert reader.span_ns == (START_NS, START_NS + 290_000_000)
    assert [share.name for share in reader.compressions] == [compression]
    assert reader.damage == ""


def test_reading_selects_topics_and_times(tmp_path: Path) -> None:
    written = write_bag(tmp_path / "a.bag")
    reader = BagReader(tmp_path / "a.bag")
    found = reader.messages(lambda each: each.topic == "/b", start_ns=written[5][1], end_ns=written[11][1])
    assert [each.payload for each in found] == [written[index][2] for index in (5, 7, 9, 11)]


def test_messages_of_overlapping_chunks_are_sorted_by_time(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / "a.bag", chunk_bytes=1)
    number = writer.add_connection(connection())
    for offset in (0, 50, 20, 10, 60, 55):
        writer.write(number, START_NS + offset, [text(str(offset))])
    writer.close()
    assert [each.time_ns - START_NS for each in BagReader(tmp_path / "a.bag").messages()] == [
        0,
        10,
        20,
        50,
        55,
        60,
    ]


def test_a_bag_truncated_anywhere_yields_its_first_messages(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    written = write_bag(path, 12)
    data = path.read_bytes()
    longest = 0
    for size in [*range(len(MAGIC), len(data), 7), len(data)]:
        path.write_bytes(data[:size])
        reader = BagReader(path)
        found = [(each.connection.topic, each.time_ns, each.payload) for each in reader.messages()]
        reader.close()
        assert found == written[: len(found)]
        assert len(found) >= longest
        longest = len(found)
    assert longest == 12


def test_a_flipped_byte_raises_only_recording_errors(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    write_bag(path, 8)
    data = path.read_bytes()
    places = [*range(len(MAGIC), len(MAGIC) + 80), *range(len(MAGIC) + 4096, len(data))]
    for place in places:
        broken = bytearray(data)
        broken[place] ^= 0x41
        path.write_bytes(broken)
        try:
            reader = BagReader(path)
            try:
                list(reader.messages())
            finally:
                reader.close()
        except RecordingError:
            continue


def test_a_chunk_that_roscpp_left_open_is_read_to_its_last_message(tmp_path: Path) -> None:
    # Until the chunk is full, roscpp writes messages after a chunk header with the size 0.
    one = connection()
    fields = encode_fields({key.encode(): value.encode() for key, value in one.fields().items()})
    known = encode_record(Op.CONNECTION, {b"conn": U32.pack(3), b"topic": b"/chatter"}, fields)
    messages = [
        encode_record(Op.MESSAGE, {b"conn": U32.pack(3), b"time": encode_time(START_NS + n)}, text(str(n)))
        for n in range(3)
    ]
    chunk = encode_record(Op.CHUNK, {b"compression": b"none", b"size": U32.pack(0)}, b"")
    data = MAGIC + bag_header(0, 0, 0) + chunk + known + b"".join(messages)
    path = tmp_path / "a.bag.active"
    path.write_bytes(data[:-2])
    reader = BagReader(path)
    assert [each.payload for each in reader.messages()] == [text("0"), text("1")]
    assert [each.topic for each in reader.counts] == ["/chatter"]


@pytest.mark.parametrize(
    ("content", "reported"),
    [
        (b"", "is empty"),
        (b"#ROSBAG V1.2\n" + bytes(100), "format 1.2"),
        (b"#ROSBAG V", "is truncated: it has only 9 bytes"),
        (b"{}" * 50, "is not a bag"),
    ],
)
def test_files_that_are_not_bags_are_reported(tmp_path: Path, content: bytes, reported: str) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=reported):
        BagReader(path)


def test_a_chunk_with_a_wrong_size_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    write_bag(path, compression="bz2")
    data = path.read_bytes()
    size = data.index(b"size=") + 5
    path.write_bytes(data[:size] + struct.pack("<I", 0xFFFFFFFF) + data[size + 4 :])
    with pytest.raises(RecordingError, match="has a wrong size"):
        list(BagReader(path).messages())


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="No such file"):
        BagReader(tmp_path / "none.bag")
