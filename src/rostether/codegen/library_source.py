"""Finds the hand-written part of the client library and its files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from rostether.errors import CodegenError

_PACKAGE = Path(__file__).parents[1]
# In a wheel, the library is inside the package; in a checkout, next to `src`.
_FOLDERS = (_PACKAGE / "client", _PACKAGE.parents[1] / "client")
# The folder of a library that compilers search for headers.
SOURCE_FOLDER = "src"
# The client library for MicroPython, which is not part of the one for C++.
MICROPYTHON_FOLDER = "micropython"


def client_library() -> Path:
    """Return the folder of the hand-written client library. Raises CodegenError if it is missing."""
    for folder in _FOLDERS:
        if (folder / SOURCE_FOLDER / "ros.h").is_file():
            return folder
    raise CodegenError(f"the client library is missing beside {_PACKAGE}; install rostether again")


def library_contents(root: Path, omitted: tuple[str, ...] = ()) -> dict[str, bytes]:
    """Return the files of `library_files` by path, without those whose path starts with one of `omitted`."""
    return {path: (root / path).read_bytes() for path in library_files(root) if not path.startswith(omitted)}


def library_files(root: Path) -> Iterator[str]:
    """Yield the paths of the files in a library's folder, with slashes, sorted.

    Hidden files and the library for MicroPython are skipped.
    """
    for folder, subfolders, files in os.walk(root):
        subfolders[:] = sorted(
            each
            for each in subfolders
            if not each.startswith(".") and each not in ("__pycache__", MICROPYTHON_FOLDER)
        )
        for file in sorted(files):
            if not file.startswith("."):
                yield (Path(folder) / file).relative_to(root).as_posix()
