"""Arduino libraries: their folders, and the choice of a library for a header.

Source: the Arduino library specification. A library with `src/` and library.properties is compiled
recursively; any other from its root and `utility/`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from pathlib import Path

from msgspec import Struct

from rostether.errors import ConfigError
from rostether.firmware.properties import parse_properties
from rostether.firmware.sketch import SOURCE_SUFFIXES

# Users install at most a few hundred libraries; a folder with more subfolders does not hold libraries.
MAX_LIBRARIES = 2000

_HEADER_SUFFIXES = (".h", ".hh", ".hpp")
_ARCHITECTURE = "avr"
# Libraries that are used if the user has none: Servo, and Ethernet for the network chip of simulated boards.
SIMULATION_LIBRARIES = Path(__file__).parent / "share" / "libraries"


class Origin(StrEnum):
    """Where a library comes from; earlier origins have priority."""

    GIVEN = "given"
    ROS = "ros_lib"
    SKETCHBOOK = "sketchbook"
    CORE = "core"
    SIMULATION = "simulation"


class UsedLibrary(Struct, frozen=True):
    """A library that a sketch was built with."""

    name: str
    folder: Path
    origin: Origin


class Library(UsedLibrary, frozen=True):
    """An available library. `is_recursive`: its sources are at any depth of its only include folder."""

    include_folders: tuple[Path, ...]
    is_recursive: bool
    fits_architecture: bool

    def provides(self, header: str) -> bool:
        """Return whether `#include <header>` finds a file here."""
        return any((folder / header).is_file() for folder in self.include_folders)

    def sources(self) -> list[Path]:
        """Return the files to compile, sorted."""
        if self.is_recursive:
            return _sources(self.include_folders[0].rglob("*"))
        folders = (self.folder, self.folder / "utility")
        return _sources(each for folder in folders if folder.is_dir() for each in folder.iterdir())


def read_library(folder: Path, origin: Origin) -> Library:
    """Return the library in a folder."""
    properties = {}
    described = folder / "library.properties"
    if described.is_file():
        properties = parse_properties(described.read_text(encoding="utf-8", errors="replace"))
    architectures = [each.strip() for each in properties.get("architectures", "*").split(",")]
    is_recursive = bool(properties) and (folder / "src").is_dir()
    include_folders = [folder / "src"] if is_recursive else [folder]
    if not is_recursive and (folder / "utility").is_dir():
        include_folders.append(folder / "utility")
    return Library(
        name=folder.name,
        folder=folder,
        origin=origin,
        include_folders=tuple(include_folders),
        is_recursive=is_recursive,
        fits_architecture=bool({"*", _ARCHITECTURE} & set(architectures)),
    )


def read_given(folder: Path) -> list[Library]:
    """Return the libraries of `--library`: one library, or a folder of them.

    Raises ConfigError for any other folder.
    """
    folder = folder.expanduser().resolve()
    if not folder.is_dir():
        raise ConfigError(f"--library {folder}: no such folder; give the folder of a library, or of several")
    if (folder / "library.properties").is_file() or _has_headers(folder):
        return [read_library(folder, Origin.GIVEN)]
    if (folder / "src").is_dir() and _has_headers(folder / "src"):
        return [read_library(folder / "src", Origin.GIVEN)]
    found = read_folder(folder, Origin.GIVEN)
    if not found:
        raise ConfigError(
            f"--library {folder}: contains no headers; give the folder of a library, or of several"
        )
    return found


def read_folder(folder: Path, origin: Origin) -> list[Library]:
    """Return the libraries in a folder, sorted by name; none if it does not exist."""
    try:
        entries = sorted(each for each in folder.iterdir() if each.is_dir() and each.name[0] != ".")
    except OSError:
        return []
    return [read_library(each, origin) for each in entries[:MAX_LIBRARIES]]


def choose(header: str, libraries: Iterable[Library]) -> Library | None:
    """Return the best library for a header: by architecture, origin, and similarity of names."""
    candidates = [each for each in libraries if each.provides(header)]
    stem = Path(header).stem.lower()
    order = list(Origin)

    def rank(library: Library) -> tuple[bool, int, bool, bool, str]:
        name = library.name.lower()
        return (
            not library.fits_architecture,
            order.index(library.origin),
            name != stem,
            not name.startswith(stem),
            name,
        )

    return min(candidates, key=rank, default=None)


def sketchbook_folders(environ: Mapping[str, str], home: Path) -> list[Path]:
    """Return the folders of the user's libraries in the IDE."""
    named = environ.get("ARDUINO_DIRECTORIES_USER")
    if named:
        return [Path(named) / "libraries"]
    return [home / "Arduino" / "libraries", home / "Documents" / "Arduino" / "libraries"]


def _has_headers(folder: Path) -> bool:
    return any(each.suffix in _HEADER_SUFFIXES for each in folder.iterdir())


def _sources(paths: Iterable[Path]) -> list[Path]:
    return sorted(each for each in paths if each.suffix in SOURCE_SUFFIXES and each.is_file())


def include_folders(libraries: Sequence[Library]) -> list[Path]:
    """Return the folders of several libraries, in order."""
    return [folder for library in libraries for folder in library.include_folders]
