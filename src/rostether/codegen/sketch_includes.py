"""Finds the includes of a sketch, of its own headers and of the library's headers."""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path

from msgspec import Struct

from rostether.codegen.library_folder import is_ros_library
from rostether.errors import ConfigError

# A large firmware project has about a hundred files; a home folder must not be read completely.
MAX_FILES = 5_000

# Longer files are pictures or sounds as C arrays, which have no includes after this.
MAX_FILE_BYTES = 1 << 21

_SOURCES = frozenset(
    {".ino", ".pde", ".c", ".cc", ".cpp", ".cxx", ".h", ".hh", ".hpp", ".hxx", ".ipp", ".tpp"}
)
_IMPLEMENTATIONS = (".cpp", ".cc", ".cxx", ".c")
# Comments and strings are skipped, so that text inside them is not read as a directive.
_TOKEN = re.compile(
    r"""
    (?P<comment> //(?:\\\n|[^\n])* | /\*.*?(?:\*/|\Z) )
    | ^[ \t]*\#[ \t]*include[ \t]*(?: <(?P<angled>[^>\n]+)> | "(?P<quoted>[^"\n]+)" )
    | R"(?P<mark>[^ ()\\\t\n]{0,16})\(.*?\)(?P=mark)"
    | "(?:\\.|[^"\\\n])*"
    | '(?:\\.|[^'\\\n])*'
    """,
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)


class Include(Struct, frozen=True):
    """One include of a file outside the sketch and the library; `location` is `file:line`."""

    path: str
    location: str


def unresolved_includes(
    sketch: Path | None, *, library_sources: Path, start: Iterable[str] = (), search: Iterable[Path] = ()
) -> list[Include]:
    """Return the includes, each once, that are not found in the sketch, the library or the folders `search`.

    `sketch` is an .ino file, a folder or a C++ file. `start` are headers of the library that are also read.
    Raises ConfigError if there is no such sketch.
    """
    files, roots = _sketch_files(sketch) if sketch is not None else ([], [])
    roots = [*roots, *search, library_sources]
    waiting = deque([*files, *(library_sources / each for each in start)])
    seen = set(waiting)
    found: dict[str, Include] = {}
    while waiting and len(seen) < MAX_FILES:
        file = waiting.popleft()
        for path, line, is_quoted in _includes(file):
            resolved = _resolve(path, [file.parent, *roots] if is_quoted else roots)
            if resolved is None:
                found.setdefault(path, Include(path, f"{file}:{line}"))
                continue
            implementations = map(resolved.with_suffix, _IMPLEMENTATIONS)
            for each in (resolved, *filter(Path.is_file, implementations)):
                if each not in seen:
                    seen.add(each)
                    waiting.append(each)
    return list(found.values())


def _sketch_files(sketch: Path) -> tuple[list[Path], list[Path]]:
    """Return the files that are compiled as the sketch, and the folders where its headers are found."""
    if sketch.is_dir():
        files = sorted(_below(sketch))
        if not files:
            raise ConfigError(f"{sketch} has no .ino or C++ file; give the sketch or its folder")
        return files, [sketch, *(sketch / each for each in ("src", "include", "lib"))]
    if not sketch.is_file():
        raise ConfigError(f"no sketch at {sketch}; give an .ino file, a folder with one, or a C++ file")
    if sketch.suffix == ".ino" and sketch.parent.name == sketch.stem:
        # Arduino compiles everything in a sketch's folder.
        return _sketch_files(sketch.parent)
    return [sketch], [sketch.parent]


def _below(folder: Path) -> Iterator[Path]:
    count = 0
    for path, subfolders, files in os.walk(folder):
        here = Path(path)
        # The includes in a generated library are not requests of the project.
        subfolders[:] = [
            each for each in subfolders if not each.startswith(".") and not is_ros_library(here / each)
        ]
        for file in files:
            if Path(file).suffix.lower() in _SOURCES and not file.startswith("."):
                yield here / file
                count += 1
        if count > MAX_FILES:
            return


def _includes(file: Path) -> Iterator[tuple[str, int, bool]]:
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_FILE_BYTES)
    except OSError:
        return
    text = data.decode("utf-8", "replace").replace("\r\n", "\n")
    if "include" not in text:
        return
    for match in _TOKEN.finditer(text):
        path = match["angled"] or match["quoted"]
        if path:
            yield path.strip(), text.count("\n", 0, match.end()) + 1, match["quoted"] is not None


def _resolve(path: str, roots: Iterable[Path]) -> Path | None:
    if "\0" in path:
        return None
    for root in roots:
        candidate = root / path
        if candidate.is_file():
            return Path(os.path.normpath(candidate))
    return None
