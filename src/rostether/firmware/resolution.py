"""Finds the libraries that a sketch needs, directly and indirectly: each missing header adds its library."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rostether.firmware.compiler import Compiler
from rostether.firmware.libraries import Library, Origin, choose, include_folders
from rostether.firmware.ros_library import RosLibrary
from rostether.firmware.sketch import Sketch

# Each round adds a library; more rounds mean that libraries include each other in a circle.
MAX_ROUNDS = 50


@dataclass(slots=True)
class Unit:
    """Sources that are compiled with the same folders of headers."""

    sources: list[Path]
    includes: list[Path]
    libraries: list[Library] = field(default_factory=list)


class Shelf:
    """The available libraries, and those chosen so far."""

    def __init__(self, libraries: Sequence[Library], ros: RosLibrary) -> None:
        self._libraries = list(libraries)
        self._ros = ros
        self.used: list[Library] = []

    def libraries_for(self, headers: Sequence[str]) -> list[Library]:
        """Return the libraries that serve headers, each once."""
        taken: dict[Path, Library] = {}
        wants_ros = False
        for header in headers:
            found = choose(header, self._libraries)
            # The library generated for this build has priority over an older one in the sketchbook.
            if (found is None or found.origin is not Origin.GIVEN) and self._ros.wants(header):
                wants_ros = True
            elif found is not None:
                taken[found.folder] = found
        if wants_ros:
            library = self._ros.write()
            taken[library.folder] = library
            # Only the last version of the generated library is kept; it has the most messages.
            self.used = [each for each in self.used if each.origin is not Origin.ROS]
        self.used += [each for each in taken.values() if each not in self.used]
        return list(taken.values())


async def resolve(
    compiler: Compiler, unit: Unit, shelf: Shelf, core: Sequence[Path], sketch: Sketch
) -> list[Unit]:
    """Complete a sketch's unit with the headers and sources it needs; return the libraries' units."""
    await _complete(compiler, unit, shelf, sketch)
    units: list[Unit] = []
    done: set[Path] = set()
    pending = list(unit.libraries)
    while pending:
        library = pending.pop(0)
        if library.folder in done:
            continue
        done.add(library.folder)
        own = Unit(library.sources(), [*core, *library.include_folders])
        if not own.sources:
            continue
        await _complete(compiler, own, shelf, None)
        units.append(own)
        pending += own.libraries
    return units


async def _complete(compiler: Compiler, unit: Unit, shelf: Shelf, sketch: Sketch | None) -> None:
    fixed = list(unit.includes)
    for _ in range(MAX_ROUNDS):
        scan = await compiler.scan(unit.sources, unit.includes)
        new = shelf.libraries_for(scan.missing)
        new = [each for each in new if each not in unit.libraries]
        found = [] if sketch is None or sketch.owns_folder else _sources_of(scan.files, sketch, unit.sources)
        if not new and not found:
            return
        if any(each.origin is Origin.ROS for each in new):
            unit.libraries = [each for each in unit.libraries if each.origin is not Origin.ROS]
        unit.libraries += new
        unit.sources += found
        unit.includes = [*fixed, *include_folders(unit.libraries)]


def _sources_of(files: Sequence[Path], sketch: Sketch, known: Sequence[Path]) -> list[Path]:
    """Return the sources of the headers that a sketch without its own folder includes."""
    sources = (sketch.headers_source(file) for file in files)
    return list(dict.fromkeys(each for each in sources if each is not None and each not in known))
