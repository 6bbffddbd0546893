"""Recordings, bags and MCAP: read and checked to their end, or refused in one line; mended ones are sound."""

from __future__ import annotations

import tempfile
from contextlib import closing
from itertools import islice
from pathlib import Path

from rostether.errors import ConfigError, RecordingError
from rostether.msgdef.registry import Registry
from rostether.recording.bag_writer import BagWriter
from rostether.recording.checking import check
from rostether.recording.files import open_recording
from rostether.recording.mcap_writer import McapWriter
from rostether.recording.recorded import Connection
from rostether.recording.reindexing import reindex

MAX_MESSAGES = 5000
# An input of a few KB may unpack to many.

_STRING = Registry().message_type("std_msgs/String")


def seeds() -> list[bytes]:
    """Return recordings of both formats, packed and plain, closed and cut."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for writer_class, compressions in (
            (BagWriter, ("none", "bz2", "lz4")),
            (McapWriter, ("none", "lz4")),
        ):
            for compression in compressions:
                path = Path(folder) / "seed"
                writer = writer_class(path, compression=compression, chunk_bytes=300)
                for index in range(12):
                    number = writer.add_connection(Connection(f"/t{index % 3}", _STRING, "/node"))
                    writer.write(number, 10**18 + index, [b"\x04\x00\x00\x00text"] * (index % 2 + 1))
                writer.flush()
                found.append(path.read_bytes())
                writer.close()
                found.append(path.read_bytes())
    # The most of a bag is the padding of its header, where changes mean nothing.
    return [*found, *(data.replace(b" " * 3000, b"") for data in found if b" " * 3000 in data)]


def run(data: bytes) -> None:
    """Read, check and mend one file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.bag"
        path.write_bytes(data)
        try:
            with closing(open_recording(path)) as reader:
                assert "\n" not in reader.damage
                times = [message.time_ns for message in islice(reader.messages(), MAX_MESSAGES)]
                assert reader.span_ns is None or all(each >= 0 for each in reader.span_ns)
        except (RecordingError, ConfigError) as error:
            assert "\n" not in str(error)
        else:
            assert len(times) <= MAX_MESSAGES
        try:
            assert all("\n" not in fault for fault in check(path, Registry(bundled=False)).faults)
            mended = Path(folder) / ("mended.mcap" if data.startswith(b"\x89MCAP") else "mended.bag")
            reindex(path, mended)
        except (RecordingError, ConfigError) as error:
            assert "\n" not in str(error)
            return
        with closing(open_recording(mended)) as reader:
            assert not reader.damage, reader.damage
