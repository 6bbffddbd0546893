"""`rostether firmware size`: how much of the board a sketch uses, and which parts use it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rostether.cli.firmware.options import build, build_options
from rostether.cli.shell.failures import EXIT_FAILED
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.running import run
from rostether.cli.shell.verbs import Verb

if TYPE_CHECKING:
    from rostether.firmware.boards import Board
    from rostether.firmware.build import BuildOptions
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.endpoints import Endpoint
    from rostether.firmware.footprint import Footprint


@click.command(
    "size",
    cls=Verb,
    examples="""
    rostether firmware size blink.ino                  for an Uno
    rostether firmware size robot --board leonardo
    rostether firmware size robot.elf --board mega     a program built elsewhere
    rostether firmware size robot --json
    """,
)
@build_options
@json_option
def firmware_size(sketch: Path, board_name: str, options: BuildOptions, as_json: bool) -> None:
    """Show how much flash and RAM a sketch uses, and which parts of it use them.

    The stack is estimated from the deepest chain of calls plus the deepest interrupt. In a sketch with ROS,
    each message is compared with the input buffer. The exit code is 1 if the sketch does not fit. If only the
    stack may be too large, the command prints a warning.
    """
    if not run(_size(sketch, board_name, options, as_json)):
        raise click.exceptions.Exit(EXIT_FAILED)


async def _size(sketch: Path, board_name: str, options: BuildOptions, as_json: bool) -> bool:
    title, footprint, endpoints, buffer_bytes = await _measure(sketch, board_name, options)
    problems = [*footprint.refusals(), *footprint.warnings()]
    problems += [
        f"{each.topic or each.name}: {each.type_name} takes {each.incoming_bytes} bytes and "
        f"{each.note(buffer_bytes)}; give ros::NodeHandle_ a larger input buffer"
        for each in endpoints
        if each.incoming_bytes is not None and buffer_bytes and each.incoming_bytes > buffer_bytes
    ]
    if as_json:
        write_json(_record(title, footprint, endpoints, buffer_bytes, problems))
    else:
        from rostether.cli.firmware.table import render

        for line in render(title, footprint, endpoints, buffer_bytes):
            write_line(line)
        for problem in problems:
            warn(f"WARNING: {problem}")
    return footprint.fits


async def _measure(
    sketch: Path, board_name: str, options: BuildOptions
) -> tuple[str, Footprint, list[Endpoint], int]:
    from rostether.firmware.build import find_board
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.footprint import measure, measure_built

    if sketch.suffix == ".elf":
        board: Board = find_board(board_name)
        elf = ElfFile.read(sketch)
        return sketch.stem, await measure(elf, board), *await _endpoints(elf, (), options)
    built = await build(sketch, board_name, options)
    elf = ElfFile.read(built.elf)
    return (
        built.sketch.name,
        await measure_built(built, elf),
        *await _endpoints(elf, built.sources, options),
    )


async def _endpoints(
    elf: ElfFile, sources: tuple[Path, ...], options: BuildOptions
) -> tuple[list[Endpoint], int]:
    from rostether.firmware.demangle import demangle
    from rostether.firmware.endpoints import find_endpoints, input_buffer_bytes
    from rostether.msgdef.registry import Registry

    readable = await demangle(each.name for each in elf.symbols)
    buffer_bytes = input_buffer_bytes(readable)
    if not buffer_bytes:
        return [], 0
    registry = Registry.from_environment(msg_paths=options.msg_paths)
    return find_endpoints(elf, readable, registry, sources), buffer_bytes


def _record(
    title: str,
    footprint: Footprint,
    endpoints: list[Endpoint],
    buffer_bytes: int,
    problems: list[str],
) -> dict[str, Any]:
    stack = footprint.stack
    return {
        "sketch": title,
        "board": footprint.board.fqbn,
        "fits": footprint.fits,
        "flash_bytes": footprint.flash_bytes,
        "flash_limit_bytes": footprint.flash_limit_bytes or None,
        "ram_bytes": footprint.ram_bytes,
        "ram_limit_bytes": footprint.ram_limit_bytes or None,
        "stack_bytes": None if stack is None else stack.total_bytes,
        "free_ram_bytes": footprint.free_ram_bytes if stack is not None else None,
        "stack": None if stack is None else asdict(stack),
        "groups": [asdict(group) for group in footprint.groups],
        "input_buffer_bytes": buffer_bytes or None,
        "endpoints": [{**asdict(each), "note": each.note(buffer_bytes)} for each in endpoints],
        "warnings": problems,
    }
