"""Files of several writers have no faults; the fault of a file damaged in one place is reported."""

from __future__ import annotations

import io
import struct
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import CompressionType, IndexType, Writer

from rostether.recording.mcap.checking import faults_of
from rostether.recording.mcap.data_check import MAX_FAULTS
from rostether.recording.mcap.reader import McapReader
from rostether.recording.mcap.records import MAGIC, Op, encode_record, read_record
from rostether.recording.mcap.writer import McapWriter
from unit.recording.bags import IMU, START_NS, connection, text, write_reset


@pytest.fixture
def ours(tmp_path: Path) -> bytearray:
    writer = McapWriter(tmp_path / "a.mcap", chunk_bytes=800)
    numbers = [writer.add_connection(connection(topic)) for topic in ("/a", "/b")]
    writer.add_connection(connection("/imu", IMU))
    for index in range(40):
        writer.write(numbers[index % 2], START_NS + index, [text(f"message {index}")])
    writer.close()
    return bytearray((tmp_path / "a.mcap").read_bytes())


def _records(data: bytes | bytearray, wanted: int) -> list[tuple[int, int, int]]:
    """Return the positions of records of a kind, and start and end of their content."""
    found = []
    position = len(MAGIC)
    while position < len(data) - len(MAGIC):
        before = position
        op, start, position = read_record(bytes(data), position)
        if op == wanted:
            found.append((before, start, position))
    return found


def _unsummed(data: bytearray) -> bytearray:
    """Remove the checksums of data and summary, so that only the damage is reported."""
    _, start, end = _records(data, Op.DATA_END)[0]
    data[start:end] = bytes(4)
    data[-12:-8] = bytes(4)
    return data


def test_own_files_have_no_faults(ours: bytearray, tmp_path: Path) -> None:
    assert faults_of(bytes(ours)) == []
    McapWriter(tmp_path / "empty.mcap").close()
    assert faults_of((tmp_path / "empty.mcap").read_bytes()) == []


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("use_chunking", [True, False])
@pytest.mark.parametrize("repeats", [True, False])
def test_files_of_the_mcap_package_have_no_faults(
    compression: CompressionType, use_chunking: bool, repeats: bool
) -> None:
    file = io.BytesIO()
    writer: Any = Writer(
        file,
        chunk_size=300,
        compression=compression,
        use_chunking=use_chunking,
        repeat_channels=repeats,
        repeat_schemas=repeats,
        index_types=IndexType.ALL if repeats else IndexType.NONE,
    )
    writer.start(profile="ros1", library="another")
    schema = writer.register_schema(IMU.name, "ros1msg", IMU.definition.encode())
    channel = writer.register_channel("/imu", "ros1", schema)
    for index in range(30):
        writer.add_message(channel, START_NS - index, bytes(20), START_NS)
    writer.add_attachment(1, 2, "a.txt", "text/plain", b"hello")
    writer.add_metadata("m", {"a": "b"})
    writer.finish()
    faults = faults_of(file.getvalue())
    if repeats:
        assert faults == []
    else:
        assert all("summary does not list the chunk" in fault for fault in faults)


def test_a_wrong_checksum_is_reported(ours: bytearray) -> None:
    _, start, end = _records(ours, Op.CHUNK)[1]
    ours[end - 5] ^= 1
    reported = faults_of(bytes(ours))
    assert any("the checksum (CRC) of its records is wrong" in fault for fault in reported)
    assert any("the checksum (CRC) of its data is wrong" in fault for fault in reported)
    assert start < end


def test_a_wrong_checksum_of_the_summary_is_reported(ours: bytearray, tmp_path: Path) -> None:
    _, start, _ = _records(ours, Op.STATISTICS)[0]
    ours[start] ^= 1
    reported = faults_of(bytes(ours))
    assert "the checksum (CRC) of its summary is wrong" in reported
    path = tmp_path / "a.mcap"
    path.write_bytes(ours)
    with closing(McapReader(path)) as reader:
        assert reader.damage == "the checksum (CRC) of its index is wrong"
        assert sum(reader.counts.values()) == 40
    assert any(fault == "its statistics state 41 messages, not 40" for fault in reported)


@pytest.mark.parametrize(
    ("op", "place", "which", "reported"),
    [
        (Op.CHUNK, 0, 0, "its times are"),
        (Op.CHUNK, 16, 0, "instead of"),
        (Op.CHUNK, 24, 0, "the checksum (CRC) of its records"),
        (Op.MESSAGE_INDEX, 6, 0, "does not list the messages of channel 1"),
        (Op.MESSAGE_INDEX, 0, 0, "does not list the messages"),
        (Op.CHUNK_INDEX, 0, 1, "wrongly"),
        (Op.CHUNK_INDEX, 16, 0, "that does not exist"),
        (Op.CHUNK_INDEX, 24, 0, "wrongly"),
        (Op.STATISTICS, 8, 0, "schemas, not 2"),
        (Op.STATISTICS, 10, 0, "channels, not 3"),
        (Op.STATISTICS, 22, 0, "chunks, not"),
        (Op.STATISTICS, 26, 0, "ns at the first message"),
        (Op.SUMMARY_OFFSET, 1, 0, "its summary offset of schema is wrong"),
        (Op.CHANNEL, 0, -1, "its summary lists channel"),
    ],
)
def test_one_wrong_byte_is_reported(ours: bytearray, op: int, place: int, which: int, reported: str) -> None:
    _, start, _ = _records(ours, op)[which]
    data = _unsummed(ours)
    data[start + place] ^= 0x40
    faults = faults_of(bytes(data))
    assert any(reported in fault for fault in faults), faults
    assert all("\n" not in fault for fault in faults)


def test_undefined_schemas_and_channels_are_reported(ours: bytearray) -> None:
    data = MAGIC + encode_record(0x01, bytes(8))
    data += encode_record(Op.CHANNEL, struct.pack("<HHIII", 1, 5, 0, 0, 0))
    data += encode_record(0x05, struct.pack("<HIQQ", 9, 0, 1, 1))
    data += encode_record(Op.DATA_END, bytes(4))
    data += encode_record(0x02, bytes(20)) + MAGIC
    assert faults_of(data) == [
        "channel 1 uses schema 5, which is not defined",
        "a message belongs to channel 9, which is not defined",
        "it has no summary",
    ]


def test_truncated_files_have_faults(ours: bytearray) -> None:
    for size in range(0, len(ours), 37):
        (*_, last) = faults_of(bytes(ours[:size]))
        assert last


def test_every_flipped_byte_of_the_data_is_reported(ours: bytearray) -> None:
    for place in range(0, len(ours), 5):
        broken = bytearray(ours)
        broken[place] ^= 0x15
        faults = faults_of(bytes(broken))
        assert faults, place
        assert len(faults) <= MAX_FAULTS + 1


def test_the_number_of_reported_faults_is_limited() -> None:
    stray = encode_record(Op.MESSAGE_INDEX, struct.pack("<HI", 1, 0))
    assert len(faults_of(MAGIC + encode_record(0x01, bytes(8)) + stray * 500)) == MAX_FAULTS + 1


def test_a_time_that_goes_back_is_reported(tmp_path: Path) -> None:
    write_reset(McapWriter(tmp_path / "a.mcap", chunk_bytes=300))
    (fault,) = faults_of((tmp_path / "a.mcap").read_bytes())
    assert fault.startswith("its time goes back once from 1029.00 s to 1.00 s")


def test_the_last_error_that_fits_may_end_the_check(ours: bytearray) -> None:
    _, start, _ = _records(ours, Op.CHUNK)[0]
    message = struct.Struct("<HIQQ")
    unknown = (encode_record(Op.MESSAGE, message.pack(100 + each, 0, 0, 0)) for each in range(MAX_FAULTS - 1))
    faults = faults_of(bytes(ours[: start - 9]) + b"".join(unknown) + bytes([Op.MESSAGE]))
    assert faults[-2:] == [
        "it ends within a record",
        f"more errors follow; only the first {MAX_FAULTS} are listed",
    ]
