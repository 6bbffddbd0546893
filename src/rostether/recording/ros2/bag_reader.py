"""Reads ROS 2 bags: folders with metadata.yaml and files of messages, of any version of rosbag2."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from rostether.errors import RecordingError
from rostether.recording.compression import CompressionShare, compression_shares, zstandard_package
from rostether.recording.file_lock import ACTIVE_SUFFIX
from rostether.recording.mcap.reader import McapReader
from rostether.recording.recorded import Connection, RecordedMessage, Wanted, merged
from rostether.recording.ros2.db3_reader import Db3Reader
from rostether.recording.ros2.metadata import FILE_NAME, Metadata, read_metadata

_SUFFIXES = (".mcap", ".db3", ".mcap.active", ".db3.active", ".mcap.zstd", ".db3.zstd")
# A few bytes can unpack to any size; larger files would fill a disk.
MAX_FILE_BYTES = 64 << 30
# The largest message that is unpacked; equal to the limit of .db3 files.
MAX_MESSAGE_BYTES = 1 << 30


class Ros2BagReader:
    """A bag being read; see `recording.recorded.RecordingReader`.

    Messages are returned as ROS 1 bytes, with the fields of ROS 2 if `is_native`. Raises RecordingError if
    the folder is not a bag, and ConfigError if an extra is missing. `damage`, if given, is the reason not to
    use the indexes of its MCAP files.
    """

    def __init__(self, path: Path, *, is_native: bool = False, damage: str = "") -> None:
        self.path = path
        self.damage = damage
        self._stack = ExitStack()
        try:
            metadata = read_metadata(path)
        except RecordingError as error:
            if not path.is_dir():
                raise
            files = sorted(each.name for each in path.iterdir() if each.name.endswith(_SUFFIXES))
            metadata = Metadata(0, "", tuple(files))
            self.damage = str(error)
        if not metadata.files:
            if (path / FILE_NAME).exists():
                raise RecordingError(
                    self.damage or f"{path / FILE_NAME} lists no files; delete it to read the folder's files"
                )
            raise RecordingError(
                f"{path} is not a ROS 2 bag: it has no {FILE_NAME} and no .mcap or .db3 files; "
                "give the folder of a bag"
            )
        self.format_version = "rosbag2"
        if metadata.storage:
            self.format_version += f" (version {metadata.version}, {metadata.storage})"
        self._files: list[McapReader | Db3Reader] = []
        try:
            for name in metadata.files:
                self._files.append(self._open(path / name, metadata, is_native=is_native, damage=damage))
                self._stack.callback(self._files[-1].close)
        except BaseException:
            self._stack.close()
            raise
        self.damage = self.damage or next((each.damage for each in self._files if each.damage), "")

    @property
    def size_bytes(self) -> int:
        """The total size of all files."""
        return sum(each.size_bytes for each in self._files)

    @property
    def counts(self) -> Mapping[Connection, int]:
        """How many messages each connection has."""
        counts: Counter[Connection] = Counter()
        for each in self._files:
            counts.update(each.counts)
        return counts

    @property
    def unreadable(self) -> Mapping[str, str]:
        """Topics with messages that cannot be converted, and why."""
        return {topic: why for each in self._files for topic, why in each.unreadable.items()}

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """The times of the first and the last message; None in an empty bag."""
        spans = [each.span_ns for each in self._files if each.span_ns is not None]
        return (min(start for start, _ in spans), max(end for _, end in spans)) if spans else None

    @property
    def compressions(self) -> Sequence[CompressionShare]:
        """How the chunks are compressed, the most frequent first."""
        return compression_shares(chunk for each in self._files for chunk in each.chunks)

    def messages(
        self, wanted: Wanted | None = None, *, start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RecordedMessage]:
        """Yield messages sorted by time, from start to end inclusive. Raises RecordingError."""
        return merged(self._files, wanted, start_ns=start_ns, end_ns=end_ns)

    def close(self) -> None:
        """Close the files. Idempotent."""
        self._stack.close()

    def _open(
        self, path: Path, metadata: Metadata, *, is_native: bool, damage: str
    ) -> McapReader | Db3Reader:
        unpack: Callable[[bytes], bytes] | None = None
        if metadata.compression_mode == "message":
            if metadata.compression_format != "zstd":
                raise RecordingError(
                    f"{self.path}: the messages are compressed with {metadata.compression_format!r}; only "
                    "zstd can be read"
                )
            unpack = partial(_unpacked_message, path)
        if path.suffix == ".zstd" or metadata.compression_mode == "file":
            path = self._unpacked_file(path)
        if path.name.removesuffix(ACTIVE_SUFFIX).endswith(".db3"):
            return Db3Reader(path, is_native=is_native, unpack=unpack)
        return McapReader(path, is_native=is_native, unpack=unpack, damage=damage)

    def _unpacked_file(self, path: Path) -> Path:
        """Return the path of the unpacked copy of a compressed file; it exists while the bag is open."""
        zstandard = zstandard_package()
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="rostether-bag-")))
        target = folder / path.name.removesuffix(".zstd")
        try:
            with (
                path.open("rb") as packed,
                target.open("wb") as file,
                zstandard.ZstdDecompressor().stream_reader(packed) as stream,
            ):
                while data := stream.read(1 << 20):
                    if file.tell() + len(data) > MAX_FILE_BYTES:
                        raise RecordingError(f"{path} decompresses to more than {MAX_FILE_BYTES} bytes")
                    file.write(data)
        except OSError as error:
            raise RecordingError(
                f"cannot decompress {path} into {folder}: {error.strerror or error}; check the path, and set "
                "TMPDIR to a folder with enough space"
            ) from None
        except zstandard.ZstdError as error:
            raise RecordingError(f"{path} is not a complete Zstandard file ({error})") from None
        return target


def _unpacked_message(path: Path, data: bytes) -> bytes:
    zstandard = zstandard_package()
    try:
        with zstandard.ZstdDecompressor().stream_reader(data) as stream:
            plain: bytes = stream.read(MAX_MESSAGE_BYTES + 1)
    except zstandard.ZstdError as error:
        raise RecordingError(f"{path}: a message compressed with zstd is broken ({error})") from None
    if len(plain) > MAX_MESSAGE_BYTES:
        raise RecordingError(f"{path}: a message decompresses to more than {MAX_MESSAGE_BYTES} bytes")
    return plain
