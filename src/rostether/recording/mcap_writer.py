"""Writes MCAP files with ROS 1 messages (profile `ros1`, schemas `ros1msg`) through the package `mcap`.

Chunks reach the file as a whole, as those of bags do. Source: mcap.dev/spec
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any, cast

from rostether.errors import ConfigError
from rostether.recording.bag_writer import DEFAULT_CHUNK_BYTES
from rostether.recording.compression import BZ2, LZ4, NONE
from rostether.recording.output_file import OutputFile
from rostether.recording.recorded import Connection


class McapWriter:
    """An MCAP file being written; see `recording.recorded.RecordingWriter`."""

    def __init__(
        self, path: Path, *, compression: str = NONE, chunk_bytes: int = DEFAULT_CHUNK_BYTES
    ) -> None:
        try:
            from mcap import writer
        except ImportError:
            raise ConfigError("MCAP is not installed; type: pip install 'rostether[recording]'") from None
        if compression == BZ2:
            raise ConfigError("MCAP knows no bz2; take lz4, or none")
        kinds = {NONE: writer.CompressionType.NONE, LZ4: writer.CompressionType.LZ4}
        self.path = path
        self.message_count = 0
        self._file = _Parts(OutputFile(path))
        self._writer: Any = writer.Writer(
            cast("IO[bytes]", self._file), chunk_size=chunk_bytes, compression=kinds[compression]
        )
        self._writer.start(profile="ros1", library="rostether")
        self._schemas: dict[tuple[str, str], int] = {}
        self._numbers: dict[Connection, int] = {}
        self._sequences: dict[int, int] = {}
        self._is_closed = False
        self._taken_bytes = 0

    @property
    def size_bytes(self) -> int:
        """The file's size, and at most what waits to be written."""
        return max(self._file.tell(), self._taken_bytes)

    def add_connection(self, connection: Connection) -> int:
        """Return the connection's number; equal connections share one."""
        number = self._numbers.get(connection)
        if number is None:
            key = (connection.type.name, connection.type.definition)
            schema = self._schemas.get(key)
            if schema is None:
                schema = self._schemas[key] = self._writer.register_schema(
                    name=connection.type.name,
                    encoding="ros1msg",
                    data=connection.type.definition.encode("utf-8", "surrogateescape"),
                )
            fields = connection.fields()
            number = self._numbers[connection] = self._writer.register_channel(
                topic=connection.topic,
                message_encoding="ros1",
                schema_id=schema,
                metadata={key: fields[key] for key in ("callerid", "latching", "md5sum") if key in fields},
            )
            self._sequences[number] = 0
        return number

    def write(self, number: int, time_ns: int, payloads: Sequence[bytes]) -> None:
        """Take messages that came at one time. Raises RecordingError when the disk takes no more."""
        sequence = self._sequences[number]
        for payload in payloads:
            self._writer.add_message(number, time_ns, payload, time_ns, sequence)
            sequence += 1
            self._taken_bytes += len(payload)
        self._sequences[number] = sequence & 0xFFFFFFFF
        self.message_count += len(payloads)
        self._file.append()

    def flush(self) -> None:
        """End the chunk and write it. Raises RecordingError."""
        self._writer.flush()
        self._file.append()

    def close(self) -> None:
        """Write the index and close the file. Idempotent. Raises RecordingError."""
        if not self._is_closed:
            self._is_closed = True
            try:
                self._writer.finish()
                self._file.append()
            finally:
                self._file.output.close()


class _Parts:
    """What the package writes, kept until a part is whole."""

    def __init__(self, output: OutputFile) -> None:
        self.output = output
        self._parts: list[bytes] = []
        self._position = 0

    def write(self, data: bytes) -> int:
        self._parts.append(bytes(data))
        self._position += len(data)
        return len(data)

    def tell(self) -> int:
        return self._position

    def flush(self) -> None:
        """Take that the package thinks of writing; `append` does."""

    def append(self) -> None:
        """Write what is there as one part. Raises RecordingError."""
        if self._parts:
            parts, self._parts = self._parts, []
            self.output.append(b"".join(parts))
