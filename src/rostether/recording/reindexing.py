"""Repairs a recording after a killed recorder, a full disk or a bad copy."""

from __future__ import annotations

import shutil
import tempfile
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from rostether.errors import RecordingError
from rostether.recording.checking import file_faults
from rostether.recording.compression import COMPRESSIONS, NONE
from rostether.recording.file_lock import ACTIVE_SUFFIX, FileLock, end_active
from rostether.recording.files import (
    BAG_SUFFIX,
    FILE_SUFFIXES,
    MCAP_SUFFIX,
    Form,
    create_recording,
    form_of,
    is_bag,
    is_mcap,
    locked,
    open_recording,
)
from rostether.recording.recorded import Connection, RecordedMessage, RecordingReader, RecordingWriter
from rostether.recording.regular_file import remove_database

if TYPE_CHECKING:
    from rostether.ros2.types.type_support import Ros2Types

UNFINISHED_SUFFIX = ".unfinished"


class Repaired(Struct, frozen=True):
    """The contents of a repaired recording, and the reason for the repair (empty if it was complete).

    `listed_count` is the number of messages in its index, None without an index.
    """

    damage: str
    message_count: int
    listed_count: int | None = None


def reindex(path: Path, output: Path, *, keep_original: Path | None = None) -> Repaired:
    """Write all readable messages of `path` to `output`, which may be the same file.

    `keep_original` is the new path of the old file, if wanted. A complete recording is not changed, unless
    `output` is another path. Raises RecordingError, and ConfigError if an extra is missing.
    """
    reader = open_recording(path, is_native=True)
    listed_count = None if reader.damage else sum(reader.counts.values())
    try:
        if not reader.damage and (faults := file_faults(path)):
            # The index is intact but the records are not: read the file without its index.
            reader.close()
            reader = open_recording(path, is_native=True, damage=faults[0])
        damage = reader.damage
        if not damage and path == output:
            if not is_mcap(path) and not is_bag(path):
                # `file_faults` does not check databases, but a damaged one cannot be read to its end.
                deque(reader.messages(), maxlen=0)
            return Repaired("", sum(reader.counts.values()))
        written = _rewrite(reader, path, output, _most_used_compression(reader), keep_original)
    finally:
        reader.close()
    return Repaired(damage, written, listed_count)


def repack(path: Path, output: Path, compression: str, *, keep_original: Path | None = None) -> int:
    """Write `path` to `output`, which may be the same file, with another compression.

    Returns the number of messages. Raises RecordingError, even for damage that `open_recording` accepts, and
    ConfigError.
    """
    with closing(open_recording(path, is_native=True)) as reader:
        if reader.damage:
            raise RecordingError(f"{path}: {reader.damage}; `rostether bag reindex {path}` repairs it")
        return _rewrite(reader, path, output, compression, keep_original)


def _rewrite(
    reader: RecordingReader, path: Path, output: Path, compression: str, keep_original: Path | None
) -> int:
    with ExitStack() as stack:
        # Do not touch a file that is still being written.
        for each in sorted(path.glob(f"*{ACTIVE_SUFFIX}")) if path.is_dir() else [path]:
            stack.enter_context(FileLock(each))
        unfinished = stack.enter_context(_unfinished(path, output))
        written = copy(reader, unfinished, compression=compression, form=form_of(reader))
        reader.close()  # SQLite merges its log into the file if the disk has space.
        if keep_original is not None:
            end_active(path, keep_original)
        end_active(unfinished, output)
    return written


@contextmanager
def _unfinished(path: Path, output: Path) -> Iterator[Path]:
    """Yield the path of the unfinished recording, which is renamed to `output` afterwards."""
    name = output.name.removesuffix(ACTIVE_SUFFIX)
    if path.is_dir():
        # The files in a ROS 2 bag's folder have its name.
        with tempfile.TemporaryDirectory(prefix=f"{UNFINISHED_SUFFIX}.", dir=output.parent) as folder:
            yield Path(folder) / name
        return
    if not name.endswith(FILE_SUFFIXES):
        name += MCAP_SUFFIX if is_mcap(path) else BAG_SUFFIX
    yield output.with_name(f"{UNFINISHED_SUFFIX}.{name}")


def copy(
    reader: RecordingReader,
    output: Path,
    *,
    compression: str = NONE,
    form: Form = Form.ROS1,
    storage: str = "mcap",
    types: Ros2Types | None = None,
) -> int:
    """Copy a recording's messages, sorted by time; return their number.

    `form` is the form of the new messages, and `storage` the file format of a ROS 2 bag. `types` replaces the
    ROS 2 types of the environment. On RecordingError, no file remains.
    """
    new = partial(create_recording, compression=compression, form=form, storage=storage, types=types)
    return write_messages(reader.messages(), output, new, reader.counts)


def write_messages(
    messages: Iterable[RecordedMessage],
    output: Path,
    create: Callable[[Path], RecordingWriter],
    connections: Iterable[Connection] = (),
) -> int:
    """Write messages to a new recording; return their number.

    The recording gets all `connections`, even those without messages. On RecordingError, no file remains.
    """
    with locked(output):
        writer = create(output)
        try:
            for connection in connections:
                writer.add_connection(connection)
            for message in messages:
                writer.write(writer.add_connection(message.connection), message.time_ns, (message.payload,))
            writer.close()
        except BaseException:
            with suppress(RecordingError):
                writer.close()
            if output.is_dir():
                shutil.rmtree(output, ignore_errors=True)
            elif output.suffix == ".db3":
                remove_database(output)
            else:
                output.unlink(missing_ok=True)
            raise
        return writer.message_count


def _most_used_compression(reader: RecordingReader) -> str:
    """Return the most frequent compression of the chunks that can be written."""
    for share in reader.compressions:
        if share.name in COMPRESSIONS:
            return share.name
    return NONE


def refuse_same(path: Path, output: Path) -> None:
    """Raise RecordingError if a command would overwrite its input."""
    if output.exists() and path.exists() and output.samefile(path):
        raise RecordingError(f"{output} is the input file; give another file")
