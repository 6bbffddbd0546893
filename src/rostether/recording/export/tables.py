"""Tables that are written row by row, and their CSV implementation."""

from __future__ import annotations

import base64
import csv
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol, TextIO

from rostether.errors import RecordingError
from rostether.mechanisms.text import write_failure
from rostether.recording.export.columns import Column
from rostether.recording.write_errors import writing
from rostether.rostime import NS_PER_S, Duration, Time
from rostether.serde.plain_form import clean_text
from rostether.serde.type_tree import Array, Number, Struct, Text
from rostether.serde.values import Message

# Spreadsheets treat a cell that begins with one of these as a formula (OWASP, CSV injection).
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")

# The time columns of a message, before its fields.
TIME_COLUMNS = ("time_s", "time_ns")


class Table(Protocol):
    """One table being written. Every method raises RecordingError if it cannot write."""

    def add(self, time_ns: int, message: Message) -> None:
        """Add a row."""

    def flush(self) -> None:
        """Write the waiting rows: all tables together may need too much memory."""

    def close(self) -> None:
        """Write the waiting rows and close the table. Idempotent."""


class CsvTable:
    """Comma-separated values in UTF-8, with lists and nested messages as JSON, and bytes as base64.

    Raises RecordingError, but BrokenPipeError if the reader of the output has ended, which is not an error.
    """

    def __init__(self, target: Path | TextIO, columns: Sequence[Column]) -> None:
        self._name = str(target) if isinstance(target, Path) else "the output"
        self._owns_file = isinstance(target, Path)
        with writing(target):
            self._file: TextIO = (
                target.open("w", encoding="utf-8", newline="") if isinstance(target, Path) else target
            )
        self._cells = [_cell_of(column) for column in columns]
        self._writer = csv.writer(self._file, lineterminator="\n")
        self._write((*TIME_COLUMNS, *(column.name for column in columns)))

    def add(self, time_ns: int, message: Message) -> None:
        """Write a row."""
        seconds, nanoseconds = divmod(time_ns, NS_PER_S)
        self._write((f"{seconds}.{nanoseconds:09d}", time_ns, *(read(message) for read in self._cells)))

    def flush(self) -> None:
        """Do nothing: rows wait only in the file's own buffer."""

    def close(self) -> None:
        """Close the table. Idempotent."""
        try:
            if self._owns_file:
                self._file.close()
            else:
                self._file.flush()
        except BrokenPipeError:
            raise
        except OSError as error:
            raise RecordingError(write_failure(self._name, error)) from None

    def _write(self, row: Sequence[Any]) -> None:
        try:
            self._writer.writerow(row)
        except BrokenPipeError:
            raise
        except OSError as error:
            raise RecordingError(write_failure(self._name, error)) from None


def nested(value: Any, bytes_as: Callable[[bytes], Any]) -> Any:
    """Return a value with messages as dicts, times in nanoseconds, and bytes converted by `bytes_as`."""
    if isinstance(value, Message):
        return {name: nested(getattr(value, name), bytes_as) for name, _ in value._fields}
    if isinstance(value, Time | Duration):
        return value.to_ns()
    if isinstance(value, bytes):
        return bytes_as(value)
    if isinstance(value, str):
        return clean_text(value)
    if isinstance(value, list):
        first = value[0] if value else 0
        return value if isinstance(first, int | float) else [nested(each, bytes_as) for each in value]
    return value


def _cell_of(column: Column) -> Callable[[Message], Any]:
    read, node = column.read, column.node
    if column.lists or isinstance(node, Array | Struct):
        is_bytes = isinstance(node, Array) and node.is_bytes and not column.lists
        return (lambda message: _base64(read(message))) if is_bytes else lambda message: _json(read(message))
    if isinstance(node, Text):
        return lambda message: _unevaluated_text(read(message) or "")
    if isinstance(node, Number) and node.name == "bool":
        return lambda message: _truth(read(message))
    return read


def _unevaluated_text(value: str) -> str:
    """Return a text that no spreadsheet treats as a formula: any board or peer may have sent it."""
    return f"'{clean_text(value)}" if value.startswith(_FORMULA_STARTS) else clean_text(value)


def _json(value: Any) -> str:
    if value is None:
        return ""
    return json.dumps(nested(value, _base64), ensure_ascii=False, separators=(",", ":"))


def _base64(value: Any) -> str:
    return "" if value is None else base64.b64encode(bytes(value)).decode()


def _truth(value: Any) -> str:
    return "" if value is None else "true" if value else "false"
