"""Writes files in one step: if it fails, for example on a full disk, the old file is still complete."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from functools import partial
from pathlib import Path


def write_whole(path: Path, content: bytes, *, is_durable: bool = False, mode: int | None = None) -> None:
    """Create or replace a file. Devices and pipes are written directly. Raises OSError.

    `mode` are the file's permissions, which the umask may reduce (None: those of the old file, or the usual
    ones). With `is_durable`, even after a power cut the file is the old or the new one. This can take seconds
    on a memory card, so call it in a thread.
    """
    target = path.resolve()
    exists = target.exists()
    if exists and not target.is_file():
        path.write_bytes(content)
        return
    fresh = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        if exists:
            # A file that may not be written is not replaced.
            target.open("ab").close()
        with open(fresh, "wb", opener=partial(os.open, mode=0o666 if mode is None else mode)) as file:
            file.write(content)
            if is_durable:
                file.flush()
                os.fsync(file.fileno())
        if exists and mode is None:
            shutil.copymode(target, fresh)
        fresh.replace(target)
    except OSError as error:
        # On a full disk, an incomplete file would take the last free space.
        with suppress(OSError):
            fresh.unlink()
        # The error names the new file, or no file if a write failed.
        error.filename = str(path)
        raise
    if is_durable and hasattr(os, "O_DIRECTORY"):
        folder = os.open(target.parent, os.O_RDONLY | os.O_DIRECTORY)
        try:
            # The new name must also be on the disk.
            os.fsync(folder)
        finally:
            os.close(folder)


def sync_file(path: Path) -> None:
    """Write the content of a file to the disk, so that it is complete after a power cut.

    Without this, a file that is renamed soon after it was written may be empty then. Like `write_whole`, this
    can take seconds.
    """
    # Windows cannot sync a file that is open for reading.
    with path.open("rb") as file, suppress(OSError):
        os.fsync(file.fileno())
