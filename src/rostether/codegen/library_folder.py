"""Replaces a generated library as a whole: a failed run does not change the old one."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from rostether.errors import CodegenError
from rostether.mechanisms.text import write_failure

# Files that only a generated library has: one of rostether, and one of the established tools.
_HEADERS = (("src/ros.h", "src/ros/node_handle.h"), ("ros.h", "ros/node_handle.h"))
_MICROPYTHON = "ros/node_handle.py"
# Another run may put its library in place between the two renames of this run; that rarely happens twice.
_ATTEMPTS = 10


def is_ros_library(folder: Path) -> bool:
    """Return whether a folder is a generated client library, of rostether or of the established tools."""
    return (folder / _MICROPYTHON).is_file() or any(
        all((folder / header).is_file() for header in headers) for headers in _HEADERS
    )


def check_parent(directory: Path, library_name: str) -> None:
    """Raise CodegenError if a folder that is to contain a library is a library itself."""
    if directory.name == library_name and is_ros_library(directory):
        raise CodegenError(
            f"{directory} is a library itself; give the folder that contains it: {directory.parent}"
        )


def write_library_folder(target: Path, files: Mapping[str, bytes]) -> bool:
    """Replace `target` by exactly these files (paths with slashes); return whether a library was replaced.

    Unchanged files keep their times, so that they are not compiled again. Raises CodegenError if the folder
    exists and is not a generated library, or if it cannot be written.
    """
    # The target of a link is replaced, not the link.
    target = target.resolve()
    replaces = _check_replaceable(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        # The temporary folder is next to the target, because a rename works only within one file system.
        with tempfile.TemporaryDirectory(
            dir=target.parent, prefix=f".{target.name}-", ignore_cleanup_errors=True
        ) as scratch:
            fresh = Path(scratch) / "new"
            _write_files(fresh, files, old=target)
            _swap(fresh, target, Path(scratch))
    except OSError as error:
        raise CodegenError(write_failure(target, error)) from error
    return replaces


def _check_replaceable(target: Path) -> bool:
    if not os.path.lexists(target):
        return False
    if not target.is_dir():
        raise CodegenError(f"{target} is a file; remove it or give another folder")
    if not any(target.iterdir()):
        return False
    if not is_ros_library(target):
        raise CodegenError(
            f"{target} is not a generated library and is not changed; remove it or give another folder"
        )
    if (target / ".git").exists():
        raise CodegenError(
            f"{target} is a git repository and is not changed; remove it or give another folder"
        )
    return True


def _write_files(folder: Path, files: Mapping[str, bytes], *, old: Path) -> None:
    for parent in sorted({(folder / path).parent for path in files} | {folder}):
        parent.mkdir(parents=True, exist_ok=True)
    for path, content in files.items():
        file = folder / path
        file.write_bytes(content)
        with contextlib.suppress(OSError):
            before = old / path
            status = before.stat()
            if status.st_size == len(content) and before.read_bytes() == content:
                os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))


def _swap(fresh: Path, target: Path, scratch: Path) -> None:
    for attempt in range(_ATTEMPTS):
        before = scratch / f"old-{attempt}"
        try:
            with contextlib.suppress(FileNotFoundError):
                target.rename(before)
            fresh.rename(target)
        # Restores the old library even if Ctrl-C interrupts between the two renames.
        except BaseException as error:
            if before.exists() and not target.exists():
                before.rename(target)
            if not isinstance(error, OSError) or attempt == _ATTEMPTS - 1 or not target.exists():
                raise
        else:
            return
