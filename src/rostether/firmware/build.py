"""From a sketch to its ELF and HEX files.

What a build depended on is recorded as a whole; when none of it has changed, the record is all that is read.
Otherwise each step asks the cache by itself, so that an edit costs one compilation and the link.
"""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable, Coroutine, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rostether.errors import FirmwareError, SketchError
from rostether.firmware.boards import Board, foreign_board, names_other_platform
from rostether.firmware.cache import BuildCache, cache_folder, digest
from rostether.firmware.compiler import Compiled, Compiler
from rostether.firmware.diagnostics import explain
from rostether.firmware.ino import active_lines, add_prototypes, join, read_ino
from rostether.firmware.libraries import (
    SIMULATION_LIBRARIES,
    Library,
    Origin,
    read_folder,
    read_given,
    sketchbook_folders,
)
from rostether.firmware.resolution import Shelf, Unit, resolve
from rostether.firmware.ros_library import RosLibrary
from rostether.firmware.sketch import SOURCE_SUFFIXES, Sketch, open_sketch
from rostether.firmware.toolchain import AvrToolchain, find_avr_toolchain


@dataclass(frozen=True, slots=True)
class BuildOptions:
    """What a build may be told besides the sketch and the board.

    `libraries` are folders of one library or of several; `warnings` has the compiler warn about the sketch;
    `show` gets every command line.
    """

    libraries: tuple[Path, ...] = ()
    msg_paths: tuple[Path, ...] = ()
    defines: tuple[str, ...] = ()
    warnings: bool = False
    uses_arduino_cli: bool = False
    show: Callable[[Sequence[str]], None] | None = None


@dataclass(frozen=True, slots=True)
class UsedLibrary:
    """A library that a sketch was built with."""

    name: str
    folder: Path
    origin: Origin


@dataclass(frozen=True, slots=True)
class BuiltFirmware:
    """What a build gave. `image` is what is flashed; `output` is what the compiler warned about."""

    sketch: Sketch
    board: Board
    elf: Path
    image: Path
    libraries: tuple[UsedLibrary, ...]
    output: str
    duration_s: float
    is_from_cache: bool = False
    sources: tuple[Path, ...] = field(default=(), repr=False)

    @property
    def simulated_libraries(self) -> list[str]:
        """The libraries that work on a simulated board only."""
        return [
            each.name
            for each in self.libraries
            if each.origin is Origin.SIMULATION and each.name in _ONLY_SIMULATED
        ]


_ONLY_SIMULATED = ("Ethernet",)
_CONTENT_VERSION = 1
"""Raised when the records of older versions must not be used any more."""


def find_board(name: str) -> Board:
    """Return a board by name. Raises ConfigError for an unknown one, FirmwareError without a core to look in."""
    if names_other_platform(name):
        return foreign_board(name)
    return find_avr_toolchain().boards.find(name)


async def build_sketch(sketch: Path, board: Board, options: BuildOptions | None = None) -> BuiltFirmware:
    """Build an .ino file, a folder with one, or a .cpp file.

    Raises FirmwareError when there is no such sketch or no compiler, SketchError when it does not compile.
    """
    options = options or BuildOptions()
    found = open_sketch(sketch)
    if options.uses_arduino_cli or not board.is_avr:
        from rostether.firmware.arduino_cli import build_with_arduino_cli

        return await build_with_arduino_cli(found, board, options)
    return await _Build(found, board, options, find_avr_toolchain()).run()


def save_outputs(built: BuiltFirmware, folder: Path) -> tuple[Path, Path]:
    """Copy the ELF and what is flashed into a folder; raises FirmwareError when it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        copies = [folder / each.name for each in (built.elf, built.image)]
        for source, copy in zip((built.elf, built.image), copies, strict=True):
            copy.write_bytes(source.read_bytes())
    except OSError as error:
        raise FirmwareError(
            f"cannot write to {folder}: {error.strerror}; give another folder with --output"
        ) from None
    return copies[0], copies[1]


class _Build:
    def __init__(self, sketch: Sketch, board: Board, options: BuildOptions, toolchain: AvrToolchain) -> None:
        self._sketch = sketch
        self._board = board
        self._options = options
        self._toolchain = toolchain
        self._cache = BuildCache(cache_folder())
        self._compiler = Compiler(toolchain, board, self._cache, defines=options.defines, show=options.show)
        self._core = list(toolchain.core_folders(board))
        self._ros = RosLibrary(self._cache, options.msg_paths)

    async def run(self) -> BuiltFirmware:
        started_s = time.monotonic()
        key = self._key()
        known = self._load(key, started_s)
        if known is not None:
            return known
        try:
            content, files, folders = await self._build()
        except* SketchError as failures:
            first = _first(failures)
            raise SketchError(
                f"{self._sketch.name} does not build for {self._board.name}: {first}",
                diagnostics=explain(first.diagnostics, self._sketch, self._ros.skipped),
            ) from None
        self._cache.save(key, content, files, folders, started_ns=time.time_ns())
        self._cache.prune(time.time())
        return self._result(content, started_s, is_from_cache=False)

    async def _build(self) -> tuple[dict[str, Any], set[Path], list[Path]]:
        roots = self._library_roots()
        async with asyncio.TaskGroup() as tasks:
            # The core needs nothing of the sketch, and is most of the work of a first build.
            core = tasks.create_task(self._build_core())
            sketch = tasks.create_task(self._build_sketch(Shelf(self._libraries(roots), self._ros)))
        objects, libraries = sketch.result()
        archive, core_objects = core.result()
        elf, image = await self._compiler.link([each.object for each in objects], archive, self._sketch.name)
        sources = [*self._sketch.inos, *self._sketch.sources]
        files = {file for each in [*objects, *core_objects] for file in each.files} | set(sources)
        files |= {elf, image}
        content = {
            "elf": str(elf),
            "image": str(image),
            "output": "".join(each.output for each in objects),
            "libraries": [[each.name, str(each.folder), each.origin] for each in libraries],
            "ros": self._ros.signature() if self._ros.packages else "",
            "sources": sorted(str(each) for each in files if self._sketch.folder in each.parents),
        }
        return content, files, [self._sketch.folder, *roots]

    async def _build_core(self) -> tuple[Path, list[Compiled]]:
        sources = [
            each
            for folder in self._core
            for each in sorted(folder.rglob("*"))
            if each.suffix in SOURCE_SUFFIXES
        ]
        objects = await _all(self._compiler.compile(each, self._core) for each in sources)
        return await self._compiler.archive([each.object for each in objects]), objects

    async def _build_sketch(self, shelf: Shelf) -> tuple[list[Compiled], list[Library]]:
        inos = [read_ino(each) for each in self._sketch.inos]
        main = [self._write_source(join(inos))] if inos else []
        unit = Unit([*main, *self._sketch.sources], [*self._core, self._sketch.folder])
        units = await resolve(self._compiler, unit, shelf, self._core, self._sketch)
        sources = [each for each in unit.sources if each not in main]
        if inos:
            preprocessed = await self._compiler.preprocess(main[0], unit.includes)
            active = None if preprocessed is None else active_lines(preprocessed)
            sources.insert(0, self._write_source(add_prototypes(inos, active)))
        warnings = "all" if self._options.warnings else "none"
        compiling = [self._compiler.compile(each, unit.includes, warnings=warnings) for each in sources]
        compiling += [
            self._compiler.compile(each, library.includes) for library in units for each in library.sources
        ]
        return await _all(compiling), shelf.used

    def _write_source(self, text: str) -> Path:
        name = f"{self._sketch.name}.ino.cpp"
        return self._cache.write_text("sources", digest("source", name, text), name, text)

    def _library_roots(self) -> list[Path]:
        given = [each.expanduser().resolve() for each in self._options.libraries]
        home = Path(os.environ.get("HOME") or Path.home())
        return [*given, *sketchbook_folders(os.environ, home), self._toolchain.libraries]

    def _libraries(self, roots: Sequence[Path]) -> list[Library]:
        given = len(self._options.libraries)
        found = [library for each in roots[:given] for library in read_given(each)]
        for folder in roots[given:-1]:
            found += read_folder(folder, Origin.SKETCHBOOK)
        found += read_folder(roots[-1], Origin.CORE)
        return found + read_folder(SIMULATION_LIBRARIES, Origin.SIMULATION)

    def _key(self) -> str:
        return digest(
            _CONTENT_VERSION,
            self._toolchain.identity,
            self._board.fqbn,
            [self._sketch.folder, *self._sketch.inos, *self._sketch.sources],
            list(self._options.libraries),
            list(self._options.msg_paths),
            list(self._options.defines),
            self._options.warnings,
            str(SIMULATION_LIBRARIES),
            os.environ.get("ROS_PACKAGE_PATH", ""),
        )

    def _load(self, key: str, started_s: float) -> BuiltFirmware | None:
        content = self._cache.load(key)
        if content is None or (content["ros"] and content["ros"] != self._ros.signature()):
            return None
        return self._result(content, started_s, is_from_cache=True)

    def _result(self, content: dict[str, Any], started_s: float, *, is_from_cache: bool) -> BuiltFirmware:
        return BuiltFirmware(
            sketch=self._sketch,
            board=self._board,
            elf=Path(content["elf"]),
            image=Path(content["image"]),
            libraries=tuple(
                UsedLibrary(name, Path(folder), Origin(origin))
                for name, folder, origin in content["libraries"]
            ),
            output=explain(content["output"], self._sketch),
            duration_s=time.monotonic() - started_s,
            is_from_cache=is_from_cache,
            sources=tuple(map(Path, content["sources"])),
        )


async def _all(compiling: Iterable[Coroutine[Any, Any, Compiled]]) -> list[Compiled]:
    """Compile all, also when one fails: whoever has two files with errors wants to see both."""
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


def _first(failures: BaseExceptionGroup[SketchError]) -> SketchError:
    """Return one error out of what a group of tasks raised."""
    for each in failures.exceptions:
        return _first(each) if isinstance(each, BaseExceptionGroup) else each
    raise AssertionError("an empty group")
