"""Runs the compiler with the recipes of platform.txt, in parallel, and only if something has changed."""

from __future__ import annotations

import asyncio
import os
import re
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from msgspec import Struct

from rostether.errors import SketchError
from rostether.firmware.boards import Board
from rostether.firmware.cache import BuildCache, digest
from rostether.firmware.toolchain import AvrToolchain
from rostether.mechanisms.program import run_program

_DEPENDENCY = re.compile(r"(?:\\.|[^\s\\])+")
_RECIPES = {".c": "c.o", ".S": "S.o"}
# Flags in a recipe that write dependencies or an object; a scan does not need them.
_OUTPUT_FLAGS = frozenset(("-c", "-MMD", "-flto", "-o", "{object_file}", "{preprocessed_file_path}"))
# With these flags the linker accepts programs that are too large, so that the report can show what needs the
# space.
_NO_SIZE_LIMITS = (
    "-Wl,--defsym=__TEXT_REGION_LENGTH__=0x400000",
    "-Wl,--defsym=__DATA_REGION_LENGTH__=0xfd00",
)


class Compiled(Struct, frozen=True):
    """An object file, the files that it depends on, and the output of the compiler."""

    object: Path
    files: tuple[Path, ...]
    output: str


class Scan(Struct, frozen=True):
    """The files that sources include, and the names of headers that were not found."""

    files: tuple[Path, ...]
    missing: tuple[str, ...]


class Compiler:
    """Builds for one board. `show` gets every command line before it runs."""

    def __init__(
        self,
        toolchain: AvrToolchain,
        board: Board,
        cache: BuildCache,
        *,
        defines: Sequence[str] = (),
        show: Callable[[Sequence[str]], None] | None = None,
    ) -> None:
        self._toolchain = toolchain
        self._board = board
        self._cache = cache
        self._defines = [f"-D{each}" for each in defines]
        self._show = show
        self._running = asyncio.Semaphore(os.cpu_count() or 1)

    async def compile(self, source: Path, includes: Sequence[Path], *, warnings: str = "none") -> Compiled:
        """Return the object of a source.

        Raises SketchError with the compiler's output, FirmwareError if the cache folder cannot be written.
        """
        recipe = self._toolchain.recipe(_RECIPES.get(source.suffix, "cpp.o"), self._board, warnings)
        arguments = self._fill(recipe, [source], includes)
        key = digest("compile", self._toolchain.identity, arguments, source)
        known = self._cache.load(key)
        if known is not None:
            found = self._cache.find("objects", known["object"], "unit.o")
            if found is not None:
                return Compiled(found, tuple(map(Path, known["files"])), known["output"])
        started_ns = time.time_ns()
        with self._cache.scratch("compiling") as folder:
            made = folder / "unit.o"
            command = [str(made) if each == "{object_file}" else each for each in arguments]
            code, output = await self._run(command)
            if code:
                name = source.name.removesuffix(".cpp") if source.stem.endswith(".ino") else source.name
                raise SketchError(f"{name} does not compile", diagnostics=output)
            files = _read_dependencies(folder / "unit.d") or (source,)
            content = digest(key, [self._cache.file_digest(file) for file in files])
            with self._cache.filling("objects", content) as kept:
                made.replace(kept / "unit.o")
        record = {"object": content, "files": [str(file) for file in files], "output": output}
        self._cache.save(key, record, files, includes, started_ns=started_ns)
        return Compiled(self._cache.path("objects", content, "unit.o"), files, output)

    async def scan(self, sources: Sequence[Path], includes: Sequence[Path]) -> Scan:
        """Return the files that sources include; missing headers are listed as written in the source.

        Raises SketchError with the compiler's output.
        """
        arguments = [*self._preprocessing([], includes), "-x", "c++", "-M", "-MG", *map(str, sources)]
        key = digest("scan", self._toolchain.identity, arguments)
        known = self._cache.load(key)
        if known is not None:
            return Scan(tuple(map(Path, known["files"])), tuple(known["missing"]))
        started_ns = time.time_ns()
        code, output = await self._run(arguments, merge=False)
        if code:
            raise SketchError("cannot read its includes", diagnostics=output)
        names = list(dict.fromkeys(_dependencies(output)))
        files = [Path(each) for each in names if Path(each).is_absolute()]
        missing = [each for each in names if not Path(each).is_absolute()]
        record = {"files": [str(each) for each in files], "missing": missing}
        self._cache.save(key, record, files, includes, started_ns=started_ns)
        return Scan(tuple(files), tuple(missing))

    async def preprocess(self, source: Path, includes: Sequence[Path]) -> str | None:
        """Return a source with conditional directives resolved and macros kept; None if that fails."""
        arguments = [*self._preprocessing([source], includes), "-E", "-fdirectives-only"]
        code, output = await self._run(arguments, merge=False)
        return None if code else output

    async def archive(self, objects: Sequence[Path]) -> Path:
        """Return an archive of objects, of which the linker uses only the needed ones.

        Raises the same errors as `compile`.
        """
        key = digest("archive", self._toolchain.identity, objects)
        found = self._cache.find("archives", key, "core.a")
        if found is not None:
            return found
        recipe = self._toolchain.recipe("ar", self._board)
        with self._cache.filling("archives", key) as folder:
            replacements = {
                "{build.path}/{archive_file}": [str(folder / "core.a")],
                "{object_file}": [str(each) for each in objects],
            }
            await self._run_or_fail(_substitute(recipe, replacements), "the core's archive")
        return self._cache.path("archives", key, "core.a")

    async def link(self, objects: Sequence[Path], archive: Path, name: str) -> tuple[Path, Path]:
        """Return the ELF and HEX files of a program. Raises the same errors as `compile`."""
        recipe = [*self._toolchain.recipe("c.combine", self._board), *_NO_SIZE_LIMITS]
        key = digest("link", self._toolchain.identity, recipe, objects, archive, name)
        elf, image = (self._cache.find("programs", key, f"{name}.{suffix}") for suffix in ("elf", "hex"))
        if elf is not None and image is not None:
            return elf, image
        with self._cache.filling("programs", key) as folder:
            project = "{build.path}/{build.project_name}"
            replacements = {
                "{object_files}": [str(each) for each in objects],
                "{build.path}/{archive_file}": [str(archive)],
                "-L{build.path}": [f"-L{folder}"],
                f"{project}.elf": [str(folder / f"{name}.elf")],
                f"{project}.hex": [str(folder / f"{name}.hex")],
            }
            await self._run_or_fail(_substitute(recipe, replacements), name)
            image_recipe = self._toolchain.recipe("objcopy.hex", self._board)
            await self._run_or_fail(_substitute(image_recipe, replacements), name)
        return (
            self._cache.path("programs", key, f"{name}.elf"),
            self._cache.path("programs", key, f"{name}.hex"),
        )

    def _preprocessing(self, sources: Sequence[Path], includes: Iterable[Path]) -> list[str]:
        recipe = self._toolchain.recipe("cpp.o", self._board)
        return self._fill([each for each in recipe if each not in _OUTPUT_FLAGS], sources, includes)

    def _fill(self, recipe: Sequence[str], sources: Sequence[Path], includes: Iterable[Path]) -> list[str]:
        replacements = {
            "{includes}": [*self._defines, *(f"-I{each}" for each in includes)],
            "{source_file}": [str(each) for each in sources],
        }
        return _substitute(recipe, replacements)

    async def _run_or_fail(self, arguments: Sequence[str], what: str) -> None:
        code, output = await self._run(arguments)
        if code:
            raise SketchError(f"{what} does not link", diagnostics=output)

    async def _run(self, arguments: Sequence[str], *, merge: bool = True) -> tuple[int, str]:
        """Return a program's exit code and output, or its error output if it failed."""
        async with self._running:
            if self._show is not None:
                self._show(arguments)
            ended = await run_program(arguments, environ={**os.environ, "LC_ALL": "C.UTF-8"}, merge=merge)
        text = ended.errors if ended.code and not merge else ended.output
        return ended.code, text.decode("utf-8", "replace")


def _substitute(recipe: Iterable[str], replacements: dict[str, list[str]]) -> list[str]:
    filled: list[str] = []
    for each in recipe:
        filled += replacements.get(each, [each] if each else [])
    return filled


def _read_dependencies(file: Path) -> tuple[Path, ...]:
    try:
        return tuple(Path(each) for each in _dependencies(file.read_text(encoding="utf-8")))
    except OSError:
        return ()


def _dependencies(rules: str) -> list[str]:
    """Return the prerequisites in make rules."""
    names = []
    for rule in rules.replace("\\\n", " ").splitlines():
        _, _, prerequisites = rule.partition(": ")
        names += [
            re.sub(r"\\(.)", r"\1", each).replace("$$", "$") for each in _DEPENDENCY.findall(prerequisites)
        ]
    return names
