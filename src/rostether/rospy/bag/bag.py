"""rosbag.Bag: reads and writes bags for scripts, like the Python module of rosbag.

It also reads MCAP files and ROS 2 bags. Source: http://wiki.ros.org/rosbag/Code%20API
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from functools import cache
from io import UnsupportedOperation
from pathlib import Path
from typing import Any

from rostether.errors import ConfigError, RecordingError
from rostether.recording.bag.writer import BagWriter
from rostether.recording.files import open_recording
from rostether.recording.recorded import Connection, RecordedMessage, RecordingReader
from rostether.recording.reindexing import reindex
from rostether.rospy.bag.facts import (
    BagMessage,
    BagMessageWithConnectionHeader,
    Compression,
    CompressionTuple,
    TypesAndTopicsTuple,
    compression_of,
    types_and_topics,
    yaml_text,
)
from rostether.rospy.bag.types import (
    ROSBagException,
    ROSBagFormatException,
    ROSBagUnindexedException,
    class_of,
    header_of,
    raw_parts,
    with_header,
)
from rostether.rospy.client.message import message_bytes, read_message
from rostether.rospy.client.message_types import message_type_of
from rostether.rospy.client.stamps import Time
from rostether.rostime import NS_PER_S

# Version 2.0 of the format, as rosbag writes it.
VERSION = 200


class Bag:
    """A bag opened for reading (`r`), writing (`w`) or appending (`a`); `skip_index` has no effect.

    Raises ROSBagException, ValueError for an invalid argument, OSError for a missing file.
    """

    def __init__(
        self,
        f: Any,
        mode: str = "r",
        compression: str = Compression.NONE,
        chunk_threshold: int = 768 * 1024,
        allow_unindexed: bool = False,
        options: Mapping[str, Any] | None = None,
        skip_index: bool = False,
    ) -> None:
        # A stream is opened again by its name, because recordings are read and written at a path.
        f = f if isinstance(f, str | Path) else getattr(f, "name", None)
        if not f or not isinstance(f, str | Path):
            raise ValueError("this rosbag needs the path of a file, or a file that has a path")
        if mode not in ("r", "w", "a"):
            raise ValueError(f'mode "{mode}" is invalid')
        settings = dict(options or {})
        self._filename = str(f)
        self._mode = mode
        self._compression = settings.get("compression", compression)
        self._chunk_threshold = settings.get("chunk_threshold", chunk_threshold)
        self._reader: RecordingReader | None = None
        self._writer: BagWriter | None = None
        self._class_of = cache(class_of)
        path = self._path = Path(f)
        # For a missing file, stat() raises FileNotFoundError, as rosbag does.
        if mode == "r":
            path.stat()
            self._reader = self._open(path)
            if self._reader.damage and not allow_unindexed:
                self.close()
                raise ROSBagUnindexedException
        elif mode == "w" or not path.exists():
            path.open("ab").close()
            self._writer = self._create(path)
        else:
            self._start_appending(path)

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[BagMessage]:
        return self.read_messages()

    def __str__(self) -> str:
        return self._get_yaml_info()

    @property
    def filename(self) -> str:
        """The file's name, as given."""
        return self._filename

    @property
    def version(self) -> int:
        """The format's version: 200."""
        return VERSION

    @property
    def mode(self) -> str:
        """The mode in which the bag was opened."""
        return self._mode

    @property
    def options(self) -> dict[str, Any]:
        """The settings of written chunks."""
        return {"compression": self._compression, "chunk_threshold": self._chunk_threshold}

    @property
    def compression(self) -> str:
        """The compression of written chunks."""
        return str(self._compression)

    @property
    def chunk_threshold(self) -> int:
        """The size of a full chunk in bytes."""
        return int(self._chunk_threshold)

    @property
    def size(self) -> int:
        """The file's size in bytes."""
        if self._writer is not None:
            return self._writer.size_bytes
        with self._reading() as reader:
            return reader.size_bytes

    def read_messages(
        self,
        topics: Any = None,
        start_time: Any = None,
        end_time: Any = None,
        connection_filter: Callable[..., bool] | None = None,
        raw: bool = False,
        return_connection_header: bool = False,
    ) -> Iterator[Any]:
        """Yield (topic, message, time) in the order of time, from `start_time` to `end_time` inclusive.

        A raw message is (type, bytes, md5sum, position, class); the position is always None.
        Raises ValueError for a closed bag, ROSBagException, and DeserializationError for a message that does
        not fit its type.
        """
        reader = self._readable()
        names = _names(topics)

        def is_wanted(connection: Connection) -> bool:
            if names is not None and connection.topic not in names:
                return False
            if connection_filter is None:
                return True
            kind = connection.type
            return bool(
                connection_filter(
                    connection.topic, kind.name, kind.md5sum, kind.definition, header_of(connection)
                )
            )

        with _rosbag_errors():
            found = reader.messages(
                is_wanted, start_ns=_nanoseconds(start_time), end_ns=_nanoseconds(end_time)
            )
        return self._converted(found, raw=raw, with_header=return_connection_header)

    def write(
        self,
        topic: str,
        msg: Any,
        t: Any = None,
        raw: bool = False,
        connection_header: Mapping[str, str | bytes] | None = None,
    ) -> None:
        """Write a message with the time `t` (default: the wall clock).

        Raises ValueError for a closed bag or a missing argument, UnsupportedOperation for a bag that was
        opened for reading, ROSBagException.
        """
        if self._writer is None:
            raise ValueError(_CLOSED) if self._reader is None else UnsupportedOperation("write")
        if not topic or msg is None:
            raise ValueError("topic or message is missing")
        time_ns = time.time_ns() if t is None else t.to_nsec()
        if raw:
            kind, payload = raw_parts(msg)
        else:
            kind, payload = message_type_of(type(msg)), message_bytes(msg)
        connection = with_header(topic, kind, connection_header or {})
        with _rosbag_errors():
            self._writer.write(self._writer.add_connection(connection), time_ns, (bytes(payload),))

    def flush(self) -> None:
        """Pass all written data to the operating system. Raises ROSBagException."""
        if self._writer is not None:
            with _rosbag_errors():
                self._writer.flush()

    def close(self) -> None:
        """Write the index and close the file. Idempotent. Raises ROSBagException."""
        writer, self._writer = self._writer, None
        reader, self._reader = self._reader, None
        if writer is not None:
            with _rosbag_errors():
                writer.close()
            if writer.path != self._path:
                writer.path.replace(self._path)
        if reader is not None:
            reader.close()

    def reindex(self) -> Iterator[int]:
        """Repair a bag that was not closed, and yield the progress in bytes. Raises ROSBagException."""
        yield 0
        if self._reader is not None:
            self._reader.close()
            with _rosbag_errors():
                reindex(self._path, self._path)
            self._reader = self._open(self._path)
        yield self.size

    def get_message_count(self, topic_filters: Any = None) -> int:
        """Return the number of messages of some topics (default: all)."""
        names = _names(topic_filters)
        with self._reading() as reader:
            counts = reader.counts
        return sum(count for each, count in counts.items() if names is None or each.topic in names)

    def get_start_time(self) -> float:
        """Return the time of the first message in seconds. Raises ROSBagException if there is none."""
        return self._span()[0] / NS_PER_S

    def get_end_time(self) -> float:
        """Return the time of the last message in seconds. Raises ROSBagException if there is none."""
        return self._span()[1] / NS_PER_S

    def get_type_and_topic_info(self, topic_filters: Any = None) -> TypesAndTopicsTuple:
        """Return the types with their md5sums, and the topics with their types, counts and frequencies.

        Raises ROSBagException.
        """
        with self._reading() as reader:
            return types_and_topics(reader, _names(topic_filters))

    def get_compression_info(self) -> CompressionTuple:
        """Return the most frequent compression, and the bytes of all chunks before and after it."""
        with self._reading() as reader:
            return compression_of(reader)

    def _get_yaml_info(self, key: str | None = None) -> str:
        with self._reading() as reader:
            return yaml_text(self._filename, reader, key)

    def _open(self, path: Path) -> RecordingReader:
        try:
            return open_recording(path)
        except (RecordingError, ConfigError) as error:
            raise ROSBagFormatException(str(error)) from None

    def _create(self, path: Path) -> BagWriter:
        try:
            return BagWriter(path, compression=self._compression, chunk_bytes=self._chunk_threshold)
        except ConfigError as error:
            raise ValueError(str(error)) from None
        except RecordingError as error:
            raise ROSBagException(str(error)) from None

    def _start_appending(self, path: Path) -> None:
        """Copy the bag to a new file; `close` replaces the bag with it."""
        reader = self._open(path)
        writer = self._create(path.with_name(f".{path.name}.unfinished"))
        with closing(reader), _rosbag_errors():
            for message in reader.messages():
                writer.write(writer.add_connection(message.connection), message.time_ns, (message.payload,))
        self._writer = writer

    def _readable(self) -> RecordingReader:
        if self._reader is None:
            if self._writer is None:
                raise ValueError(_CLOSED)
            # After a flush, the file has only whole chunks, so it can be read like a bag that was not closed.
            self.flush()
            return self._open(self._writer.path)
        return self._reader

    @contextmanager
    def _reading(self) -> Iterator[RecordingReader]:
        """Provide a reader of the bag; as in rosbag, even of a closed bag."""
        if self._reader is not None:
            with _rosbag_errors():
                yield self._reader
            return
        own = self._readable() if self._writer is not None else self._open(self._path)
        with closing(own) as reader, _rosbag_errors():
            yield reader

    def _span(self) -> tuple[int, int]:
        with self._reading() as reader:
            span_ns = reader.span_ns
        if span_ns is None:
            raise ROSBagException("Bag contains no message")
        return span_ns

    def _converted(self, found: Iterator[RecordedMessage], *, raw: bool, with_header: bool) -> Iterator[Any]:
        with _rosbag_errors():
            for connection, time_ns, payload in found:
                stamp = Time(*divmod(time_ns, NS_PER_S))
                made = self._class_of(connection.type)
                message: Any
                if raw:
                    message = (connection.type.name, payload, connection.type.md5sum, None, made)
                else:
                    message = read_message(made, payload)
                if with_header:
                    header = header_of(connection)
                    yield BagMessageWithConnectionHeader(connection.topic, message, stamp, header)
                else:
                    yield BagMessage(connection.topic, message, stamp)


_CLOSED = "I/O operation on closed bag"


@contextmanager
def _rosbag_errors() -> Iterator[None]:
    """Raise the errors of recordings in the block as rosbag's."""
    try:
        yield
    except (RecordingError, ConfigError) as error:
        raise ROSBagException(str(error)) from None


def _names(topics: Any) -> frozenset[str] | None:
    if not topics:
        return None
    return frozenset([topics] if isinstance(topics, str) else topics)


def _nanoseconds(stamp: Any) -> int | None:
    return None if stamp is None else int(stamp.to_nsec())
