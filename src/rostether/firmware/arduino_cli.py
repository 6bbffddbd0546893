"""Builds with arduino-cli: for boards other than AVR, and for users who prefer its compiler versions."""

from __future__ import annotations

import re
import time
from pathlib import Path

from rostether.errors import FirmwareError, SketchError
from rostether.firmware.boards import Board
from rostether.firmware.built_firmware import BuildOptions, BuiltFirmware
from rostether.firmware.cache import BuildCache, cache_folder, digest
from rostether.firmware.diagnostics import explain
from rostether.firmware.libraries import choose, read_given
from rostether.firmware.ros_library import RosLibrary
from rostether.firmware.sketch import Sketch, included_headers
from rostether.firmware.toolchain import find_arduino_cli
from rostether.mechanisms.program import run_program

_IMAGES = (".hex", ".uf2", ".bin")
_PLATFORM_MISSING = re.compile(r"[Pp]latform '?([\w:]+)[^\n]*not (?:found|installed)")


async def build_with_arduino_cli(sketch: Sketch, board: Board, options: BuildOptions) -> BuiltFirmware:
    """Build like `build_sketch`, with the same errors.

    The ROS library is generated for the includes of the sketch's own files.
    """
    started_s = time.monotonic()
    program = find_arduino_cli(f"building for {board.title}")
    cache = BuildCache(cache_folder())
    libraries = [library for each in options.libraries for library in read_given(each)]
    ros = RosLibrary(cache, sketch.definition_folders(options.msg_paths))
    headers = included_headers(sketch.files((".h",)))
    if [each for each in headers if choose(each, libraries) is None and ros.add_header(each)]:
        libraries.append(ros.write())
    key = digest(sketch.folder, sketch.name, board.fqbn, options.defines)
    output_folder = cache.folder / "arduino-cli" / key[:2] / key[2:]
    command = [program, "compile", "--fqbn", board.fqbn, "--output-dir", str(output_folder)]
    for library in libraries:
        command += ["--library", str(library.folder)]
    command += ["--warnings", "all" if options.warnings else "none"]
    if options.defines:
        flags = " ".join(f"-D{each}" for each in options.defines)
        for language in ("c", "cpp"):
            command += ["--build-property", f"compiler.{language}.extra_flags={flags}"]
    command.append(str(_sketch_folder(sketch, cache)))
    if options.show is not None:
        options.show(command)
    ended = await run_program(command)
    output = explain(ended.output.decode("utf-8", "replace"), sketch)
    if ended.code:
        raise SketchError(_reason(sketch, board, output), diagnostics=output)
    return BuiltFirmware(
        sketch=sketch,
        board=board,
        elf=_find(output_folder, (".elf",)),
        image=_find(output_folder, _IMAGES),
        libraries=tuple(libraries),
        output=output if options.warnings else "",
        duration_s=time.monotonic() - started_s,
        sources=(*sketch.inos, *sketch.sources),
    )


def _sketch_folder(sketch: Sketch, cache: BuildCache) -> Path:
    """Return a folder that arduino-cli accepts: it has the name of its .ino file."""
    if any(each == sketch.folder / f"{sketch.folder.name}.ino" for each in sketch.inos):
        return sketch.folder
    files = {each.name: each.read_bytes() for each in (*sketch.inos, *sketch.sources)}
    files.setdefault(f"{sketch.name}.ino", b"")
    key = digest("folder", sketch.name, sorted((name, content.hex()) for name, content in files.items()))
    name = f"{sketch.name}/{sketch.name}.ino"
    if cache.find("sketches", key, name) is None:
        with cache.filling("sketches", key) as folder:
            (folder / sketch.name).mkdir()
            for each, content in files.items():
                (folder / sketch.name / each).write_bytes(content)
    return cache.path("sketches", key, name).parent


def _find(folder: Path, suffixes: tuple[str, ...]) -> Path:
    for suffix in suffixes:
        # Other files may contain the bootloader.
        found = [
            each
            for each in sorted(folder.glob(f"*{suffix}"))
            if not re.search(r"bootloader|partitions|merged", each.name)
        ]
        if found:
            return found[0]
    raise FirmwareError(f"arduino-cli wrote no {' or '.join(suffixes)} file to {folder}; see --verbose")


def _reason(sketch: Sketch, board: Board, output: str) -> str:
    missing = _PLATFORM_MISSING.search(output)
    if missing is not None:
        platform = ":".join(board.fqbn.split(":")[:2])
        return f"arduino-cli has no platform {platform}; run: arduino-cli core install {platform}"
    return f"{sketch.name} does not build for {board.name}"
