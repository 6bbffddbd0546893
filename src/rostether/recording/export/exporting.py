"""Writes the messages of a recording as tables, one for each topic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, closing
from fnmatch import fnmatchcase

from msgspec import Struct

from rostether.errors import ConfigError, RostetherError, SerializationError
from rostether.recording.decoding import Decoder
from rostether.recording.export.columns import Column, columns_of
from rostether.recording.export.tables import Table
from rostether.recording.recorded import Connection, RecordingReader

# The limit of open files; more topics are written in several passes.
MAX_OPEN_TABLES = 100

# The limit for unwritten data of all tables; as Python values it needs a few times as much memory.
MAX_WAITING_BYTES = 32 << 20

# The approximate memory of a value besides the bytes of its message.
_CELL_BYTES = 8


class ExportedTable(Struct):
    """One topic with messages of one type; `number` distinguishes the tables of a topic with several types.

    `unfit_count` is the number of messages omitted because they do not fit their type; `why` is the reason
    for the first one.
    """

    topic: str
    type_name: str
    number: int
    connections: tuple[Connection, ...]
    columns: Sequence[Column]
    row_count: int = 0
    unfit_count: int = 0
    why: str = ""

    @property
    def name(self) -> str:
        """The name of its file; the dot is safe because ROS names have no dots."""
        name = self.topic.strip("/").replace("/", ".") or "topic"
        return name if not self.number else f"{name}.{self.number + 1}"


class Export:
    """The part of a recording to write: topics by name or pattern, and their fields."""

    def __init__(
        self,
        reader: RecordingReader,
        *,
        topics: Sequence[str] = (),
        fields: Sequence[str] = (),
        type_name: str = "",
        report: Callable[[str], None],
    ) -> None:
        """Select topics; `report` gets a line for each topic that is skipped.

        With `type_name`, only topics of this type are selected. Raises ConfigError if no topic remains.
        """
        self._reader = reader
        self._decoder = Decoder()
        by_type: dict[tuple[str, str, str], list[Connection]] = {}
        for connection in reader.counts:
            is_chosen = not topics or any(fnmatchcase(connection.topic, _with_slash(each)) for each in topics)
            if is_chosen and type_name in ("", connection.type.name):
                key = (connection.topic, connection.type.md5sum, connection.type.name)
                by_type.setdefault(key, []).append(connection)
        self.tables: list[ExportedTable] = []
        errors: list[ConfigError] = []
        for (topic, _, found_type), connections in sorted(by_type.items()):
            try:
                columns = columns_of(self._decoder.codec(connections[0]), fields)
            except ConfigError as error:  # Other topics may have that field.
                errors.append(ConfigError(f"{topic}: {error}"))
                continue
            except RostetherError as error:
                report(f"{topic}: its definition of {found_type} is broken; the topic is skipped: {error}")
                continue
            number = sum(table.topic == topic for table in self.tables)
            table = ExportedTable(topic, found_type, number, tuple(connections), columns)
            self.tables.append(table)
        if not self.tables:
            if errors:
                raise errors[0]
            if by_type:
                raise ConfigError("no topic can be written")
            known = ", ".join(sorted({each.topic for each in reader.counts})) or "none"
            missing = " or ".join(topics)
            if type_name:
                missing = f"{missing} has the type {type_name}".lstrip()
            raise ConfigError(f"no topic {missing or 'can be written'}; the recording has {known}")

    def write(self, create: Callable[[ExportedTable], Table]) -> None:
        """Write all tables in the order of the messages; `create` opens a table. Raises RecordingError."""
        for start in range(0, len(self.tables), MAX_OPEN_TABLES):
            self._write_tables(self.tables[start : start + MAX_OPEN_TABLES], create)

    def _write_tables(
        self, tables: Iterable[ExportedTable], create: Callable[[ExportedTable], Table]
    ) -> None:
        with ExitStack() as opened:
            targets: dict[Connection, tuple[ExportedTable, Table]] = {}
            for table in tables:
                target = opened.enter_context(closing(create(table)))
                targets |= dict.fromkeys(table.connections, (table, target))
            waiting_bytes = 0
            for found in self._reader.messages(targets.__contains__):
                table, target = targets[found.connection]
                try:
                    message = self._decoder.decode(found)
                except SerializationError as error:
                    table.unfit_count += 1
                    table.why = table.why or str(error)
                    continue
                target.add(found.time_ns, message)
                table.row_count += 1
                waiting_bytes += len(found.payload) + _CELL_BYTES * len(table.columns)
                if waiting_bytes > MAX_WAITING_BYTES:
                    waiting_bytes = 0
                    for _, each in targets.values():
                        each.flush()


def _with_slash(topic: str) -> str:
    return topic if topic.startswith(("/", "*")) else f"/{topic}"
