"""Opening recordings by the name of their file: `.mcap`, else a ROS 1 bag."""

from __future__ import annotations

from pathlib import Path

from rostether.errors import ConfigError
from rostether.recording.bag_reader import BagReader
from rostether.recording.bag_writer import DEFAULT_CHUNK_BYTES, BagWriter
from rostether.recording.compression import NONE
from rostether.recording.recorded import RecordingReader, RecordingWriter

MCAP_SUFFIX = ".mcap"
MCAP_MAGIC = b"\x89MCAP"


def open_recording(path: Path) -> RecordingReader:
    """Open a recording to read. Raises RecordingError, ConfigError when the extra is missing."""
    if is_mcap(path):
        from rostether.recording.mcap_reader import McapReader

        return McapReader(path)
    return BagReader(path)


def create_recording(
    path: Path, *, compression: str = NONE, chunk_bytes: int = DEFAULT_CHUNK_BYTES
) -> RecordingWriter:
    """Create a recording, over one that is there. Raises RecordingError, ConfigError."""
    name = path.name.removesuffix(".active")
    if name.endswith(MCAP_SUFFIX):
        from rostether.recording.mcap_writer import McapWriter

        return McapWriter(path, compression=compression, chunk_bytes=chunk_bytes)
    if not name.endswith(".bag") and not name.endswith(".bag.orig"):
        raise ConfigError(f"{path}: a recording's name ends with .bag or .mcap")
    return BagWriter(path, compression=compression, chunk_bytes=chunk_bytes)


def is_mcap(path: Path) -> bool:
    """Tell whether a file is MCAP, by what it begins with; a file that cannot be read is none."""
    try:
        with path.open("rb") as file:
            return file.read(len(MCAP_MAGIC)) == MCAP_MAGIC
    except OSError:
        return False
