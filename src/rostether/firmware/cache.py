"""The build cache: content-addressed, safe with parallel builds, and limited in size.

A file is stored under the hash of everything it depends on, by renaming. Records (JSON) list the dependencies
of a command's last run: while none of them has changed, its result is valid.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rostether.errors import FirmwareError
from rostether.mechanisms.user_folders import FolderKind, user_folder
from rostether.mechanisms.whole_file import sync_file

# The objects of a core need 1 MB for each board, those of a sketch about 300 KB.
MAX_CACHE_BYTES = 256 * 1024 * 1024
# Well below the limit, so that the next builds need no pruning.
PRUNE_TO_BYTES = MAX_CACHE_BYTES * 3 // 4
# Measuring the cache reads the state of every file in it.
PRUNE_INTERVAL_S = 3600.0
# Files used in the last hour are always kept: a parallel build may need them for linking.
RECENT_S = 3600.0

# The files that a build reads.
_SOURCE_SUFFIXES = frozenset(["ino", "pde", "h", "hh", "hpp", "c", "cc", "cpp", "cxx", "S", "properties"])


def cache_folder() -> Path:
    """Return the cache folder; its content can be rebuilt."""
    return user_folder(FolderKind.CACHE) / "firmware"


def digest(*parts: object) -> str:
    """Return the hash of values: 32 hexadecimal digits."""
    text = json.dumps(parts, default=str)
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()[:32]


class BuildCache:
    """The files and records of one cache folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._digests: dict[str, str] = {}

    def path(self, kind: str, key: str, name: str) -> Path:
        """Return the path of a file in the entry of a kind and key."""
        return self.folder / kind / key[:2] / key[2:] / name

    def find(self, kind: str, key: str, name: str) -> Path | None:
        """Return a file and mark it as used; None if it does not exist."""
        path = self.path(kind, key, name)
        try:
            os.utime(path)
        except OSError:
            return None
        return path

    @contextmanager
    def filling(self, kind: str, key: str) -> Iterator[Path]:
        """Provide an empty folder to write to; it is stored under the key if the block succeeds.

        Raises FirmwareError if the cache folder cannot be written.
        """
        target = self.path(kind, key, "")
        with self.scratch(kind) as folder:
            yield folder
            for path in folder.rglob("*"):
                if path.is_file():
                    sync_file(path)
            # If another build was faster, its files are the same.
            with contextlib.suppress(OSError):
                target.parent.mkdir(exist_ok=True)
                folder.rename(target)

    @contextmanager
    def scratch(self, kind: str) -> Iterator[Path]:
        """Provide an empty folder, which is removed at the end of the block.

        Raises FirmwareError if the cache folder cannot be written.
        """
        # Prune finds entries at this depth, including those of a build that was killed.
        parent = self.folder / kind / "new"
        try:
            parent.mkdir(parents=True, exist_ok=True)
            folder = Path(tempfile.mkdtemp(dir=parent))
        except OSError as error:
            raise FirmwareError(
                f"cannot write to {self.folder}: {error.strerror}; set XDG_CACHE_HOME to a writable folder"
            ) from None
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def write_text(self, kind: str, key: str, name: str, text: str) -> Path:
        """Store a text under a key if it is missing; return its path. Raises FirmwareError."""
        found = self.find(kind, key, name)
        if found is None:
            with self.filling(kind, key) as folder:
                (folder / name).write_bytes(text.encode("utf-8", "surrogateescape"))
        return self.path(kind, key, name)

    def load(self, key: str) -> Any | None:
        """Return the record of a key if all files that it depends on are unchanged, else None."""
        path = self._record(key)
        try:
            record = json.loads(path.read_bytes())
            if not self._is_fresh(record["files"], record["folders"]):
                return None
            os.utime(path)
        except (OSError, ValueError, KeyError, TypeError):
            return None
        return record["content"]

    def save(
        self, key: str, content: Any, files: Iterable[Path], folders: Iterable[Path], *, started_ns: int
    ) -> None:
        """Store a record with its dependencies, unless one of them was changed after `started_ns`."""
        states = []
        for file in files:
            status = file.stat()
            # Files in the cache never change.
            if status.st_mtime_ns >= started_ns and self.folder not in file.parents:
                return
            states.append([str(file), status.st_size, status.st_mtime_ns, self.file_digest(file)])
        record = {"content": content, "files": states, "folders": [[str(f), listing(f)] for f in folders]}
        path = self._record(key)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(prefix=".new-", dir=path.parent)
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            json.dump(record, stream)
        Path(temporary).replace(path)

    def file_digest(self, file: Path) -> str:
        """Return the hash of a file's content, which is read only once in a build. Raises OSError."""
        name = str(file)
        if name not in self._digests:
            self._digests[name] = hashlib.sha256(file.read_bytes()).hexdigest()[:32]
        return self._digests[name]

    def prune(self, now_s: float) -> None:
        """Remove the least recently used entries if the cache is too large. Checks the size once an hour."""
        stamp = self.folder / "pruned"
        with contextlib.suppress(OSError):
            if stamp.exists() and now_s - stamp.stat().st_mtime < PRUNE_INTERVAL_S:
                return
            self.folder.mkdir(parents=True, exist_ok=True)
            stamp.touch()
            self._remove_oldest(now_s)

    def _remove_oldest(self, now_s: float) -> None:
        entries = [_measure(entry) for entry in self.folder.glob("*/*/*")]
        total = sum(size for _, size, _ in entries)
        if total <= MAX_CACHE_BYTES:
            return
        for used_s, size, entry in sorted(entries):
            if total <= PRUNE_TO_BYTES or now_s - used_s < RECENT_S:
                break
            # Remove it in one step, not file by file: no other process must find an incomplete entry.
            removed = entry.with_name(f".old-{entry.name}")
            with contextlib.suppress(OSError):
                entry.rename(removed)
                shutil.rmtree(removed) if removed.is_dir() else removed.unlink()
                total -= size

    def _record(self, key: str) -> Path:
        return self.folder / "records" / key[:2] / f"{key[2:]}.json"

    def _is_fresh(self, files: list[list[Any]], folders: list[list[str]]) -> bool:
        for name, size, mtime_ns, content in files:
            status = os.stat(name)  # noqa: PTH116 - hundreds of them; Path takes twice as long
            if status.st_size == size and status.st_mtime_ns == mtime_ns:
                continue
            if status.st_size != size or self.file_digest(Path(name)) != content:
                return False
        return all(listing(Path(name)) == seen for name, seen in folders)


def _measure(entry: Path) -> tuple[float, int, Path]:
    """Return the time of last use of an entry, its size, and the entry."""
    used_s, size = 0.0, 0
    for path in [entry, *entry.rglob("*")]:
        with contextlib.suppress(OSError):
            status = path.lstat()
            if not stat.S_ISDIR(status.st_mode):
                used_s = max(used_s, status.st_mtime)
                size += status.st_size
    return used_s, size, entry


def listing(folder: Path) -> str:
    """Return a hash of the names in a folder that a build may search; an empty string if it is missing."""
    try:
        with os.scandir(folder) as entries:
            names = sorted(
                entry.name
                for entry in entries
                if not entry.name.startswith(".")
                and (entry.name.rpartition(".")[2] in _SOURCE_SUFFIXES or entry.is_dir())
            )
    except OSError:
        return ""
    return digest(names)
