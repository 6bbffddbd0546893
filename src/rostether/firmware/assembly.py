"""The steps of a build, each with its own cache entry: an edit costs one compilation and the link."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Coroutine, Iterable, Sequence
from pathlib import Path
from typing import Any

from msgspec import Struct, field

from rostether.errors import SketchError, first_error
from rostether.firmware.boards import Board
from rostether.firmware.cache import BuildCache, digest
from rostether.firmware.compiler import Compiled, Compiler
from rostether.firmware.ino import active_lines, add_prototypes, join, read_ino
from rostether.firmware.libraries import (
    SIMULATION_LIBRARIES,
    Library,
    Origin,
    choose,
    include_folders,
    read_folder,
    read_given,
    sketchbook_folders,
)
from rostether.firmware.ros_library import RosLibrary
from rostether.firmware.sketch import SOURCE_SUFFIXES, Sketch
from rostether.firmware.toolchain import AvrToolchain

# Each round adds a library; more rounds mean that libraries include each other in a cycle.
MAX_ROUNDS = 50


class Assembled(Struct, frozen=True):
    """A linked program, its sources, and the folders where a new file could change the build."""

    elf: Path
    image: Path
    libraries: Sequence[Library]
    output: str
    files: frozenset[Path]
    folders: Sequence[Path]


class Assembly(Struct, frozen=True):
    """Compiles and links one sketch for one board."""

    sketch: Sketch
    board: Board
    toolchain: AvrToolchain
    cache: BuildCache
    ros: RosLibrary
    compiler: Compiler

    async def assemble(self, given: Sequence[Path], *, warnings: bool) -> Assembled:
        """Compile and link. `given` are the user's libraries. Raises the errors of `build_sketch`."""
        given = [each.expanduser().resolve() for each in given]
        sketchbooks = sketchbook_folders(os.environ, Path(os.environ.get("HOME") or Path.home()))
        libraries = [library for each in given for library in read_given(each)]
        libraries += [library for each in sketchbooks for library in read_folder(each, Origin.SKETCHBOOK)]
        libraries += read_folder(self.toolchain.libraries, Origin.CORE)
        libraries += read_folder(SIMULATION_LIBRARIES, Origin.SIMULATION)
        choice = LibraryChoice(libraries, self.ros)
        try:
            async with asyncio.TaskGroup() as tasks:
                # The core does not depend on the sketch, and is most of the work of a first build.
                core = tasks.create_task(self._build_core())
                sketch = tasks.create_task(self._build_sketch(choice, "all" if warnings else "none"))
        except BaseExceptionGroup as failures:
            raise first_error(failures) from None
        objects, (archive, core_objects) = sketch.result(), core.result()
        elf, image = await self.compiler.link([each.object for each in objects], archive, self.sketch.name)
        files = {file for each in [*objects, *core_objects] for file in each.files}
        return Assembled(
            elf=elf,
            image=image,
            libraries=choice.used,
            output="".join(each.output for each in objects),
            files=frozenset((*files, *self.sketch.inos, *self.sketch.sources, elf, image)),
            folders=[self.sketch.folder, *given, *sketchbooks, self.toolchain.libraries],
        )

    @property
    def core(self) -> tuple[Path, Path]:
        """The folders of the core's sources and of the board's pin table."""
        return self.toolchain.core_folders(self.board)

    async def _build_core(self) -> tuple[Path, list[Compiled]]:
        sources = [
            each
            for folder in self.core
            for each in sorted(folder.rglob("*"))
            if each.suffix in SOURCE_SUFFIXES
        ]
        objects = await _all(self.compiler.compile(each, self.core) for each in sources)
        return await self.compiler.archive([each.object for each in objects]), objects

    async def _build_sketch(self, choice: LibraryChoice, warnings: str) -> list[Compiled]:
        inos = [read_ino(each) for each in self.sketch.inos]
        main = [self._write_source(join(inos))] if inos else []
        unit = Unit([*main, *self.sketch.sources], [*self.core, self.sketch.folder])
        units = await resolve(self.compiler, unit, choice, self.core, self.sketch)
        sources = [each for each in unit.sources if each not in main]
        if inos:
            preprocessed = await self.compiler.preprocess(main[0], unit.includes)
            active = None if preprocessed is None else active_lines(preprocessed)
            sources.insert(0, self._write_source(add_prototypes(inos, active)))
        compiling = [self.compiler.compile(each, unit.includes, warnings=warnings) for each in sources]
        compiling += [
            self.compiler.compile(each, library.includes) for library in units for each in library.sources
        ]
        return await _all(compiling)

    def _write_source(self, text: str) -> Path:
        name = f"{self.sketch.name}.ino.cpp"
        return self.cache.write_text("sources", digest("source", name, text), name, text)


async def _all(compiling: Iterable[Coroutine[Any, Any, Compiled]]) -> list[Compiled]:
    """Compile all files even if one fails, to report the errors of all."""
    results = await asyncio.gather(*compiling, return_exceptions=True)
    failures = [each for each in results if isinstance(each, SketchError)]
    if failures:
        # One header's error is reported by each source that includes it.
        diagnostics = dict.fromkeys(each.diagnostics for each in failures)
        raise SketchError(str(failures[0]), diagnostics="".join(diagnostics))
    for each in results:
        if isinstance(each, BaseException):
            raise each
    return [each for each in results if isinstance(each, Compiled)]


class Unit(Struct):
    """Sources that are compiled with the same folders of headers."""

    sources: list[Path]
    includes: list[Path]
    libraries: list[Library] = field(default_factory=list)


class LibraryChoice:
    """The available libraries, and those chosen so far."""

    def __init__(self, libraries: Sequence[Library], ros: RosLibrary) -> None:
        self._libraries = list(libraries)
        self._ros = ros
        self.used: list[Library] = []

    def libraries_for(self, headers: Sequence[str]) -> list[Library]:
        """Return the libraries that provide headers, each once."""
        chosen: dict[Path, Library] = {}
        wants_ros = False
        for header in headers:
            found = choose(header, self._libraries)
            # The library generated for this build has priority over an older one in the sketchbook.
            if (found is None or found.origin is not Origin.GIVEN) and self._ros.add_header(header):
                wants_ros = True
            elif found is not None:
                chosen[found.folder] = found
        if wants_ros:
            library = self._ros.write()
            chosen[library.folder] = library
            # Only the last version of the generated library is kept; it has the most messages.
            self.used = [each for each in self.used if each.origin is not Origin.ROS]
        self.used += [each for each in chosen.values() if each not in self.used]
        return list(chosen.values())


async def resolve(
    compiler: Compiler, unit: Unit, choice: LibraryChoice, core: Sequence[Path], sketch: Sketch
) -> list[Unit]:
    """Complete a sketch's unit with the headers and sources it needs; return the libraries' units."""
    await _complete(compiler, unit, choice, sketch)
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
        await _complete(compiler, own, choice, None)
        units.append(own)
        pending += own.libraries
    return units


async def _complete(compiler: Compiler, unit: Unit, choice: LibraryChoice, sketch: Sketch | None) -> None:
    fixed = list(unit.includes)
    for _ in range(MAX_ROUNDS):
        scan = await compiler.scan(unit.sources, unit.includes)
        new = choice.libraries_for(scan.missing)
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
