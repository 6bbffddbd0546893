"""Tables as Parquet files, with the package `pyarrow` (extra `parquet`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rostether.errors import RecordingError
from rostether.extras import imported_from
from rostether.mechanisms.text import fold_line, write_failure
from rostether.recording.export.columns import Column
from rostether.recording.export.tables import TIME_COLUMNS, nested
from rostether.rostime import NS_PER_S
from rostether.serde.type_tree import Array, Node, Number, Stamp, Struct, Text
from rostether.serde.values import Message

# The maximum number of rows in a group: enough rows that the columns compress well.
MAX_GROUP_ROWS = 50_000

_NUMBERS = {"byte": "int8", "char": "uint8", "bool": "bool_"}


def parquet_package() -> Any:
    """Return `pyarrow` with `pyarrow.parquet`. Raises ConfigError if it is not installed."""
    with imported_from("parquet", "Parquet support is not installed"):
        import pyarrow
        import pyarrow.parquet
    return pyarrow


class ParquetTable:
    """A Parquet file being written; see `recording.export.tables.Table`.

    Raises RecordingError, and ConfigError if `pyarrow` is not installed.
    """

    def __init__(self, path: Path, columns: Sequence[Column]) -> None:
        self._arrow = arrow = parquet_package()
        self._path = path
        self._columns = columns
        fields = [
            arrow.field(TIME_COLUMNS[0], arrow.float64()),
            arrow.field(TIME_COLUMNS[1], arrow.int64()),
            *(arrow.field(column.name, _type_of(arrow, column)) for column in columns),
        ]
        self._schema = arrow.schema(fields)
        self._values: list[list[Any]] = [[] for _ in fields]
        self._is_closed = False
        with self._explained_errors():
            try:
                self._writer = arrow.parquet.ParquetWriter(str(path), self._schema)
            except arrow.ArrowNotImplementedError:
                # Parquet does not support the type; the file has already been created.
                path.unlink(missing_ok=True)
                raise

    def add(self, time_ns: int, message: Message) -> None:
        """Add a row; write the waiting rows if there are many."""
        values = self._values
        values[0].append(time_ns / NS_PER_S)
        values[1].append(time_ns)
        for index, column in enumerate(self._columns, 2):
            values[index].append(nested(column.read(message), bytes))
        if len(values[0]) >= MAX_GROUP_ROWS:
            self.flush()

    def flush(self) -> None:
        """Write the waiting rows."""
        if not self._values[0]:
            return
        arrow = self._arrow
        waiting, self._values = self._values, [[] for _ in self._values]
        with self._explained_errors():
            columns = [
                arrow.array(values, type=field.type)
                for values, field in zip(waiting, self._schema, strict=True)
            ]
            self._writer.write_table(arrow.Table.from_arrays(columns, schema=self._schema))

    def close(self) -> None:
        """Write the waiting rows and close the file. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = True
        try:
            self.flush()
        finally:
            with self._explained_errors():
                self._writer.close()

    @contextmanager
    def _explained_errors(self) -> Iterator[None]:
        """Convert the package's errors (full disk, unsupported type) to RecordingError."""
        try:
            yield
        except OSError as error:
            raise RecordingError(write_failure(self._path, error)) from None
        except self._arrow.ArrowException as error:
            reason = fold_line(str(error))
            raise RecordingError(
                f"cannot write {self._path}: {reason}; choose other fields, or the format CSV"
            ) from None


def _type_of(arrow: Any, column: Column) -> Any:
    if isinstance(column.node, Stamp) and not column.lists and column.name.endswith("_s"):
        return arrow.float64()
    found = _node_type(arrow, column.node)
    for _ in range(column.lists):
        found = arrow.list_(found)
    return found


def _node_type(arrow: Any, node: Node) -> Any:
    if isinstance(node, Number):
        return getattr(arrow, _NUMBERS.get(node.name, node.name))()
    if isinstance(node, Stamp):
        return arrow.int64()
    if isinstance(node, Text):
        return arrow.string()
    if isinstance(node, Array):
        return arrow.binary() if node.is_bytes else arrow.list_(_node_type(arrow, node.element))
    assert isinstance(node, Struct)
    return arrow.struct([arrow.field(member.name, _node_type(arrow, member.node)) for member in node.members])
