"""Finds the files of a sketch."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from itertools import islice
from pathlib import Path

from msgspec import Struct

from rostether.errors import FirmwareError
from rostether.packages.locate import package_around

INO_SUFFIXES = (".ino", ".pde")
SOURCE_SUFFIXES = (".c", ".cpp", ".cc", ".cxx", ".S")
# If a home folder is given by mistake, the search must not read all of its files.
MAX_SKETCH_FILES = 2000

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"\n]+)[>"]', re.MULTILINE)


class Sketch(Struct, frozen=True):
    """The files of a sketch: `inos` in the order in which they are joined, and separate `sources`.

    `owns_folder` is false for a sketch in a folder of other files: it owns only the sources whose headers it
    includes.
    """

    name: str
    folder: Path
    inos: tuple[Path, ...]
    sources: tuple[Path, ...]
    owns_folder: bool

    def headers_source(self, header: Path) -> Path | None:
        """Return the source file of a header in the sketch's folder, if there is one."""
        if self.folder not in header.parents:
            return None
        candidates = (header.with_suffix(suffix) for suffix in SOURCE_SUFFIXES)
        return next((each for each in candidates if each.is_file()), None)

    def files(self, suffixes: Collection[str]) -> list[Path]:
        """Return its files, and those of its own folder with some suffixes. Raises FirmwareError."""
        below = files_below(self.folder, suffixes) if self.owns_folder else ()
        return list(dict.fromkeys((*self.inos, *self.sources, *below)))

    def definition_folders(self, msg_paths: Sequence[Path]) -> tuple[Path, ...]:
        """Return the first folders to search for messages: --msg-path, then the package of the sketch."""
        package = package_around(self.folder.resolve())
        return tuple(msg_paths) if package is None else (*msg_paths, package)


def open_sketch(path: Path) -> Sketch:
    """Return the sketch in an .ino or .cpp file, or in a folder. Raises FirmwareError if there is none."""
    path = path.expanduser()
    if path.is_dir():
        return _open_folder(path.resolve())
    if not path.exists():
        raise FirmwareError(f"no sketch {path}; give an .ino file, a folder with one, or a .cpp file")
    path = path.resolve()
    if path.suffix in INO_SUFFIXES:
        if path.stem == path.parent.name:
            return _open_folder(path.parent)
        return Sketch(path.stem, path.parent, (path,), (), owns_folder=False)
    if path.suffix in SOURCE_SUFFIXES:
        return Sketch(path.stem, path.parent, (), (path,), owns_folder=False)
    raise FirmwareError(f"{path.name} is not a sketch; give an .ino file, a folder with one, or a .cpp file")


def _open_folder(folder: Path) -> Sketch:
    here = [each for each in folder.iterdir() if each.is_file() and not each.name.startswith(".")]
    inos = sorted(each for each in here if each.suffix in INO_SUFFIXES)
    sources = sorted(each for each in here if each.suffix in SOURCE_SUFFIXES)
    main = [each for each in inos if each.stem == folder.name]
    if not main and len(inos) > 1:
        names = ", ".join(each.name for each in inos)
        raise FirmwareError(f"{folder} contains several sketches ({names}); give one of them")
    if not inos and not sources:
        raise FirmwareError(f"{folder} contains no .ino or .cpp file; give the folder of a sketch")
    first = (main or inos)[:1]
    rest = [each for each in inos if each not in first]
    sources += files_below(folder / "src", SOURCE_SUFFIXES)
    return Sketch(folder.name, folder, (*first, *rest), tuple(sources), owns_folder=True)


def files_below(folder: Path, suffixes: Collection[str]) -> list[Path]:
    """Return the files with some suffixes in a folder of a sketch, at any depth, if it exists; sorted.

    Raises FirmwareError if there are too many files for a sketch.
    """
    found = list(islice(folder.rglob("*"), MAX_SKETCH_FILES + 1)) if folder.is_dir() else []
    if len(found) > MAX_SKETCH_FILES:
        raise FirmwareError(
            f"{folder} contains more than {MAX_SKETCH_FILES} files; give the folder of a sketch"
        )
    return sorted(each for each in found if each.suffix in suffixes and each.is_file())


def included_headers(files: Iterable[Path]) -> list[str]:
    """Return the names of the headers that files include, as written there."""
    texts = (each.read_text(encoding="utf-8", errors="replace") for each in files)
    return [header for text in texts for header in _INCLUDE.findall(text)]
