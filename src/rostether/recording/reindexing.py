"""Makes a whole recording of what a killed recorder, a full disk or a bad copy has left."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rostether.errors import RecordingError
from rostether.recording.compression import NONE
from rostether.recording.files import create_recording, is_mcap, open_recording
from rostether.recording.recorded import RecordingReader

UNFINISHED_SUFFIX = ".unfinished"


@dataclass(frozen=True, slots=True)
class Mended:
    """What was found in a recording, and why it needed to be mended (an empty string: it was whole)."""

    damage: str
    message_count: int
    backup: Path | None


def reindex(path: Path, output: Path, *, keep_original: Path | None = None) -> Mended:
    """Write all that is whole in `path` to `output`, perhaps the same; `keep_original` gets the old file.

    A recording that is whole is left alone, unless it is to go elsewhere. Raises RecordingError.
    """
    reader = open_recording(path)
    try:
        damage = reader.damage
        count = sum(reader.counts.values())
        if not damage and path == output:
            return Mended("", count, None)
        name = output.name.removesuffix(".active")
        if not name.endswith((".bag", ".mcap")):
            name += ".mcap" if is_mcap(path) else ".bag"
        unfinished = output.with_name(f"{UNFINISHED_SUFFIX}.{name}")
        written = copy(reader, unfinished, compression=_usual(reader))
    finally:
        reader.close()
    if keep_original is not None:
        path.replace(keep_original)
    unfinished.replace(output)
    return Mended(damage, written, keep_original)


def copy(reader: RecordingReader, output: Path, *, compression: str = NONE) -> int:
    """Write a recording's messages, in the order of their times, to another file; returns how many.

    Raises RecordingError, and leaves no file then.
    """
    writer = create_recording(output, compression=compression)
    try:
        for connection in reader.counts:
            writer.add_connection(connection)
        for message in reader.messages():
            writer.write(writer.add_connection(message.connection), message.time_ns, (message.payload,))
        writer.close()
    except BaseException:
        output.unlink(missing_ok=True)
        raise
    return writer.message_count


def _usual(reader: RecordingReader) -> str:
    """Return how most chunks are compressed, where it can be written."""
    for share in reader.compressions:
        if share.name in ("none", "bz2", "lz4"):
            return share.name
    return NONE


def refuse_same(path: Path, output: Path) -> None:
    """Raise RecordingError when a command would write over what it reads."""
    if output.exists() and path.exists() and output.samefile(path):
        raise RecordingError(f"{output} is what is read; name another file")
