from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from rostether.errors import ConfigError, RecordingError
from rostether.recording.mcap.reader import McapReader
from rostether.recording.mcap.records import MAGIC, RECORD_HEAD, encode_record
from rostether.recording.mcap.writer import McapWriter
from unit.recording.bags import IMU, START_NS, STRING, connection, text


def _write(path: Path, *, closes: bool = True, compression: str = "none") -> None:
    writer = McapWriter(path, chunk_bytes=500, compression=compression)
    numbers = [writer.add_connection(connection(topic)) for topic in ("/a", "/b")]
    writer.add_connection(connection("/imu", IMU))
    for index in range(40):
        writer.write(numbers[index % 2], START_NS + index, [text(f"message {index}")])
    if closes:
        writer.close()
    else:
        writer.flush()


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_the_mcap_package_reads_own_files(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "a.mcap"
    _write(path, compression=compression)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros1"
        found = list(reader.iter_messages())
        summary = reader.get_summary()
    assert summary is not None
    assert [message.log_time - START_NS for _, _, message in found] == list(range(40))
    schema, channel, message = found[0]
    assert schema is not None
    assert (schema.name, schema.encoding, schema.data.decode()) == (STRING.name, "ros1msg", STRING.definition)
    assert (channel.topic, channel.message_encoding, channel.metadata["callerid"]) == (
        "/a",
        "ros1",
        "/talker",
    )
    assert message.data == text("message 0")
    assert {each.topic for each in summary.channels.values()} == {"/a", "/b", "/imu"}


def test_flushed_messages_are_read_from_a_file_that_was_not_closed(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    _write(path, closes=False)
    reader = McapReader(path)
    assert reader.damage
    assert [each.time_ns - START_NS for each in reader.messages()] == list(range(40))
    assert {each.topic: count for each, count in reader.counts.items()} == {"/a": 20, "/b": 20}


def test_a_file_truncated_anywhere_yields_its_first_messages_or_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    _write(path)
    data = path.read_bytes()
    max_count = 0
    for size in range(8, len(data), 61):
        path.write_bytes(data[:size])
        try:
            reader = McapReader(path)
            found = [each.time_ns - START_NS for each in reader.messages()]
            reader.close()
        except RecordingError:
            continue
        assert found == list(range(len(found)))
        max_count = max(max_count, len(found))
    assert max_count == 40


def test_missing_md5sums_are_computed(tmp_path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer: Any = Writer(file, compression=CompressionType.NONE)
        writer.start(profile="ros1", library="another")
        schema = writer.register_schema(IMU.name, "ros1msg", IMU.definition.encode())
        channel = writer.register_channel("/imu", "ros1", schema)
        writer.add_message(channel, START_NS, b"abc", START_NS)
        writer.finish()
    reader = McapReader(path)
    assert [each.connection.type for each in reader.messages()] == [IMU]


@pytest.mark.parametrize("use_chunking", [True, False])
@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_files_of_the_mcap_package_are_read(tmp_path: Path, compression: str, use_chunking: bool) -> None:
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer: Any = Writer(
            file, chunk_size=500, compression=CompressionType[compression], use_chunking=use_chunking
        )
        writer.start(profile="ros1", library="another")
        schema = writer.register_schema(STRING.name, "ros1msg", STRING.definition.encode())
        channels = [writer.register_channel(topic, "ros1", schema) for topic in ("/a", "/b")]
        for index in range(40):
            # Of each two messages, the later one is first, even across chunks.
            writer.add_message(channels[index % 2], START_NS + (index ^ 1), text(str(index ^ 1)), START_NS)
        writer.finish()
    reader = McapReader(path)
    assert bool(reader.damage) != use_chunking
    assert [each.payload for each in reader.messages()] == [text(str(index)) for index in range(40)]
    assert {each.topic: count for each, count in reader.counts.items()} == {"/a": 20, "/b": 20}
    some = list(reader.messages(lambda each: each.topic == "/a", start_ns=START_NS + 9, end_ns=START_NS + 15))
    assert [each.time_ns - START_NS for each in some] == [9, 11, 13, 15]


def test_a_length_beyond_the_end_of_the_file_needs_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    for op in range(1, 0x10):
        path.write_bytes(MAGIC + encode_record(1, bytes(8)) + RECORD_HEAD.pack(op, 1 << 62) + b"abc")
        reader = McapReader(path)
        assert "ends within a record" in reader.damage
        assert not list(reader.messages())
        reader.close()


def test_bz2_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="not support bz2"):
        McapWriter(tmp_path / "a.mcap", compression="bz2")
    assert not (tmp_path / "a.mcap").exists()
