"""Bags and MCAP files: read and checked to their end, or refused in one line; repaired ones are valid."""

from __future__ import annotations

import random
import struct
import tempfile
from contextlib import closing
from itertools import islice
from pathlib import Path

from fuzz.grammar import near
from fuzz.lowering import lowered
from rostether.errors import ConfigError, RecordingError
from rostether.msgdef.registry import Registry
from rostether.recording import compression
from rostether.recording.bag import chunks as bag_chunks
from rostether.recording.bag.writer import BagWriter
from rostether.recording.checking import check
from rostether.recording.files import open_recording
from rostether.recording.mcap.writer import McapWriter
from rostether.recording.recorded import Connection
from rostether.recording.reindexing import reindex

# An input of a few KB may unpack to a large size.
MAX_MESSAGES = 5000
MAX_CHUNK_BYTES = 64 << 10
MAX_CONNECTIONS = 8

_STRING = Registry().message_type("std_msgs/String")


def seeds() -> list[bytes]:
    """Return recordings in both formats, compressed and plain, complete and cut."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for writer_class, compressions in (
            (BagWriter, ("none", "bz2", "lz4")),
            (McapWriter, ("none", "lz4")),
        ):
            for packing in compressions:
                path = Path(folder) / "seed"
                writer = writer_class(path, compression=packing, chunk_bytes=300)
                for index in range(12):
                    number = writer.add_connection(Connection(f"/t{index % 3}", _STRING, "/node"))
                    writer.write(number, 10**18 + index, [b"\x04\x00\x00\x00text"] * (index % 2 + 1))
                writer.flush()
                found.append(path.read_bytes())
                writer.close()
                found.append(path.read_bytes())
    # Most of a bag is the padding of its header, where changes have no effect.
    return [*found, *(data.replace(b" " * 3000, b"") for data in found if b" " * 3000 in data)]


def generate(source: random.Random) -> bytes:
    """Return a recording with a few topics, with a changed number, or with a small chunk of large content."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made"
        make = source.choice((BagWriter, McapWriter))
        packing = source.choice(("none", "lz4") if make is McapWriter else ("none", "bz2", "lz4"))
        writer = make(path, compression=packing, chunk_bytes=source.choice((100, 1000)))
        count = near(source, MAX_CONNECTIONS) % 12
        for index in range(source.randint(0, 12)):
            number = writer.add_connection(Connection(f"/t{index % (count + 1)}", _STRING, "/node"))
            writer.write(number, 10**18 + source.randrange(20), [b"\x04\x00\x00\x00text"])
        if packing != "none" and source.random() < 0.3:
            number = writer.add_connection(Connection("/large", _STRING, "/node"))
            writer.write(number, 10**18, [bytes(near(source, MAX_CHUNK_BYTES) % (1 << 20))])
        if source.random() < 0.8:
            writer.close()
        else:
            writer.flush()
        data = path.read_bytes()
        writer.close()
    if source.random() < 0.6:
        place = source.randrange(len(data))
        data = data[:place] + struct.pack("<I", near(source, len(data))) + data[place + 4 :]
    return data if source.random() < 0.9 else data[: source.randrange(len(data))]


def run(data: bytes) -> None:
    """Read, check and repair one file, with low limits."""
    with (
        lowered(compression, MAX_CHUNK_BYTES=MAX_CHUNK_BYTES),
        lowered(bag_chunks, MAX_CONNECTIONS=MAX_CONNECTIONS),
    ):
        _read(data)


def _read(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.bag"
        path.write_bytes(data)
        try:
            with closing(open_recording(path)) as reader:
                assert "\n" not in reader.damage
                messages = list(islice(reader.messages(), MAX_MESSAGES))
                largest = max((len(message.payload) for message in messages), default=0)
                assert largest <= max(MAX_CHUNK_BYTES, len(data)), "a chunk unpacks to more than allowed"
                times = [message.time_ns for message in messages]
                assert reader.span_ns is None or all(each >= 0 for each in reader.span_ns)
        except (RecordingError, ConfigError) as error:
            assert "\n" not in str(error)
        else:
            assert len(times) <= MAX_MESSAGES
        try:
            assert all("\n" not in fault for fault in check(path, Registry(bundled=False)).faults)
            mended = Path(folder) / ("repaired.mcap" if data.startswith(b"\x89MCAP") else "repaired.bag")
            reindex(path, mended)
        except (RecordingError, ConfigError) as error:
            assert "\n" not in str(error)
            return
        with closing(open_recording(mended)) as reader:
            assert not reader.damage, reader.damage
