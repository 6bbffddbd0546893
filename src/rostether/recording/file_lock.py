"""Marks the file of a recording while it is written, so that no other program writes it."""

from __future__ import annotations

import contextlib
import itertools
import os
import sys
from collections.abc import Callable
from pathlib import Path

from rostether.errors import RecordingError
from rostether.recording.regular_file import sqlite_logs

# The suffix of a file while it is written, as with rosbag.
ACTIVE_SUFFIX = ".active"


class FileLock(contextlib.AbstractContextManager["FileLock"]):
    """Locks a file for writing until `release`; a missing file is created.

    Without file locks (Windows, some network file systems), or if the file is not writable, it does nothing.
    Raises RecordingError if another writer has locked it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._is_new = not path.exists()
        self._file = _locked(path)

    def release(self) -> None:
        """Release the lock, and remove the file if it is new and still empty. Idempotent."""
        file, self._file = self._file, None
        if file is None:
            return
        if self._is_new and not os.fstat(file).st_size:
            self.path.unlink(missing_ok=True)
        os.close(file)

    def __exit__(self, *_error: object) -> None:
        """Release the lock."""
        self.release()


def _locked(path: Path) -> int | None:
    # Windows cannot rename an open file, and recordings are renamed while they are locked.
    if sys.platform == "win32":
        return None
    import fcntl

    while True:
        try:
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NONBLOCK, 0o666)
        except OSError:
            return None  # The error is reported when the file is opened for writing.
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            raise RecordingError(
                f"{path} is being written by another recorder; stop that recorder, or choose another file"
            ) from None
        except OSError:
            os.close(file)
            return None
        # The previous writer may have renamed the file between the two calls.
        if _is_same(file, path):
            return file
        os.close(file)


def _is_same(file: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except OSError:
        return False


def end_active(active: Path, path: Path) -> None:
    """Rename `active` and its log files to `path` and its log files, which it replaces. Raises OSError."""
    active.replace(path)
    if path.suffix != ".db3":
        return
    for active_log, log in zip(sqlite_logs(active), sqlite_logs(path), strict=True):
        log.unlink(missing_ok=True)
        with contextlib.suppress(FileNotFoundError):
            active_log.replace(log)


def lock_active(active: Path, path: Path, report: Callable[[str], None]) -> FileLock:
    """Lock the file of a new recording; a file that a killed recorder has left is renamed and reported.

    Raises RecordingError if another recorder writes the file, or it cannot be renamed.
    """
    lock = FileLock(active)
    try:
        kept = _keep_left_over(active, path)
    except OSError as error:
        lock.release()
        raise RecordingError(
            f"cannot rename {active}, which a recorder has left: {error.strerror or error}; move it away"
        ) from None
    if kept is None:
        return lock
    lock.release()
    report(
        f"{active} was left by a recorder that was killed: renamed it to {kept.name}; "
        f"`rostether bag reindex {kept}` gives it an index"
    )
    return FileLock(active)


def _keep_left_over(active: Path, path: Path) -> Path | None:
    """Rename the file to the name of the recording with a number, such as `drive.killed-1.bag`."""
    if not active.exists() or not active.stat().st_size:
        return None
    names = (path.with_name(f"{path.stem}.killed-{number}{path.suffix}") for number in itertools.count(1))
    kept = next(each for each in names if not each.exists())
    end_active(active, kept)
    return kept
