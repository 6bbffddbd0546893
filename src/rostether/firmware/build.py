"""Builds the ELF and HEX files of a sketch.

One record lists all dependencies of a build; if none has changed, only this record is read. Otherwise each
step uses its own cache entry, so that an edit costs one compilation and the link.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rostether.errors import FirmwareError, SketchError
from rostether.firmware.boards import Board, other_platform_fqbn
from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
from rostether.firmware.cache import BuildCache, cache_folder, digest
from rostether.firmware.libraries import SIMULATION_LIBRARIES, Origin, UsedLibrary
from rostether.firmware.ros_library import RosLibrary
from rostether.firmware.sketch import Sketch, open_sketch
from rostether.firmware.toolchain import AvrToolchain, find_avr_toolchain

# Increase this number when records of older versions are no longer valid.
_CONTENT_VERSION = 1


def find_board(name: str) -> Board:
    """Return a board by name. Raises ConfigError for an unknown one, FirmwareError without a core."""
    if (fqbn := other_platform_fqbn(name)) is not None:
        return Board(name=fqbn, title=fqbn, fqbn=fqbn)
    return find_avr_toolchain().boards.find(name)


async def build_sketch(sketch: Path, board: Board, options: BuildOptions | None = None) -> BuiltFirmware:
    """Build an .ino file, a folder with one, or a .cpp file.

    Raises FirmwareError if there is no such sketch or no compiler, SketchError if it does not compile,
    ConfigError for a folder without libraries, DefinitionError for an invalid message definition.
    """
    options = options or BuildOptions()
    found = open_sketch(sketch)
    if options.uses_arduino_cli or not board.is_avr:
        from rostether.firmware.arduino_cli import build_with_arduino_cli

        return await build_with_arduino_cli(found, board, options)
    return await _Build(found, board, options, find_avr_toolchain()).run()


def save_outputs(built: BuiltFirmware, folder: Path) -> tuple[Path, Path]:
    """Copy the ELF and the image into a folder. Raises FirmwareError if it cannot be written."""
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
        self._ros = RosLibrary(self._cache, sketch.definition_folders(options.msg_paths))

    async def run(self) -> BuiltFirmware:
        started_s = time.monotonic()
        key = self._key()
        known = self._load(key, started_s)
        if known is not None:
            return known
        # Imported late: an unchanged build does not need it.
        from rostether.firmware.assembly import Assembly
        from rostether.firmware.compiler import Compiler

        options = self._options
        compiler = Compiler(
            self._toolchain, self._board, self._cache, defines=options.defines, show=options.show
        )
        assembly = Assembly(self._sketch, self._board, self._toolchain, self._cache, self._ros, compiler)
        try:
            made = await assembly.assemble(options.libraries, warnings=options.warnings)
        except SketchError as error:
            raise SketchError(
                f"{self._sketch.name} does not build for {self._board.name}: {error}",
                diagnostics=_explain(error.diagnostics, self._sketch, self._ros.skipped),
            ) from None
        content = {
            "elf": str(made.elf),
            "image": str(made.image),
            "output": made.output,
            "libraries": [[each.name, str(each.folder), each.origin] for each in made.libraries],
            "ros": self._ros.signature() if self._ros.packages else "",
            "sources": sorted(str(each) for each in made.files if self._sketch.folder in each.parents),
        }
        self._cache.save(key, content, made.files, made.folders, started_ns=time.time_ns())
        self._cache.prune(time.time())
        return self._result(content, started_s, is_from_cache=False)

    def _key(self) -> str:
        return digest(
            _CONTENT_VERSION,
            self._toolchain.identity,
            self._board.fqbn,
            [self._sketch.folder, *self._sketch.inos, *self._sketch.sources],
            list(self._options.libraries),
            list(self._sketch.definition_folders(self._options.msg_paths)),
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
            output=_explain(content["output"], self._sketch),
            duration_s=time.monotonic() - started_s,
            is_from_cache=is_from_cache,
            sources=tuple(map(Path, content["sources"])),
        )


def _explain(output: str, sketch: Sketch, skipped: Sequence[str] = ()) -> str:
    if not output:
        return ""
    from rostether.firmware.diagnostics import explain

    return explain(output, sketch, skipped)
