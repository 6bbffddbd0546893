"""`rostether firmware size`: how much of the board a sketch uses, and which parts use it."""

from __future__ import annotations

import io
import re
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import to_builtins
from rich.console import Console
from rich.table import Table

from rostether.cli.firmware.options import SketchOptions, build, sketch_options
from rostether.cli.shell.failures import EXIT_DONE, EXIT_FAILED
from rostether.cli.shell.output import json_option, warn, write_json, write_line
from rostether.cli.shell.verbs import verb
from rostether.firmware.build import find_board
from rostether.msgdef.registry import Registry

if TYPE_CHECKING:
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.footprint import Footprint, Group
    from rostether.firmware.sketch_endpoints import Endpoint
    from rostether.firmware.stack import StackEstimate

# Wider tables are not easier to read.
MAX_COLUMNS = 100
# More names of items do not fit beside the numbers.
SHOWN_ITEMS = 3
_BAR_CELLS = 20
_TEMPLATE = re.compile(r"<[^<>]*>")
# Longer chains of calls fill several lines.
_MAX_SHOWN_CALLS = 6


@verb(
    "size",
    """
    rostether firmware size blink.ino                  for an Uno
    rostether firmware size robot --board leonardo
    rostether firmware size robot.elf --board mega     a program built elsewhere
    rostether firmware size robot --json
    """,
)
@sketch_options
@json_option
async def firmware_size(options: SketchOptions, as_json: bool) -> int:
    """Show how much flash and RAM a sketch uses, and which parts of it use them.

    The stack is estimated from the deepest chain of calls plus the deepest interrupt. In a sketch with ROS,
    each message is compared with the input buffer. The exit code is 1 if the sketch does not fit. If only the
    stack may be too large, the command prints a warning.
    """
    title, footprint, endpoints, buffer_bytes = await _measure(options)
    problems = [*footprint.refusals(), *footprint.warnings()]
    problems += [
        f"{each.topic or each.name}: {each.type_name} has {each.incoming_bytes} bytes and "
        f"{each.note(buffer_bytes)}; give ros::NodeHandle_ a larger input buffer"
        for each in endpoints
        if each.incoming_bytes is not None and each.incoming_bytes > buffer_bytes
    ]
    if as_json:
        write_json(_record(title, footprint, endpoints, buffer_bytes, problems))
    else:
        for line in render(title, footprint, endpoints, buffer_bytes):
            write_line(line)
        for problem in problems:
            warn(f"WARNING: {problem}")
    return EXIT_DONE if footprint.fits else EXIT_FAILED


async def _measure(options: SketchOptions) -> tuple[str, Footprint, list[Endpoint], int]:
    from rostether.firmware.elf import ElfFile
    from rostether.firmware.footprint import measure, measure_built

    if options.sketch.suffix == ".elf":
        elf = ElfFile.read(options.sketch)
        footprint = await measure(elf, find_board(options.board))
        return options.sketch.stem, footprint, *await _endpoints(elf, (), options)
    built = await build(options)
    elf = ElfFile.read(built.elf)
    return built.sketch.name, await measure_built(built, elf), *await _endpoints(elf, built.sources, options)


async def _endpoints(
    elf: ElfFile, sources: tuple[Path, ...], options: SketchOptions
) -> tuple[list[Endpoint], int]:
    from rostether.firmware.demangle import demangle
    from rostether.firmware.sketch_endpoints import find_endpoints, input_buffer_bytes

    readable = await demangle(each.name for each in elf.symbols)
    buffer_bytes = input_buffer_bytes(readable)
    if not buffer_bytes:
        return [], 0
    registry = Registry.from_environment(msg_paths=options.msg_paths)
    return find_endpoints(elf, readable, registry, sources), buffer_bytes


def _record(
    title: str, footprint: Footprint, endpoints: list[Endpoint], buffer_bytes: int, problems: list[str]
) -> dict[str, Any]:
    stack = footprint.stack
    return {
        "sketch": title,
        "board": footprint.board.fqbn,
        "fits": footprint.fits,
        "flash_bytes": footprint.flash_bytes,
        "flash_limit_bytes": footprint.board.flash_bytes or None,
        "ram_bytes": footprint.ram_bytes,
        "ram_limit_bytes": footprint.board.ram_bytes or None,
        "stack_bytes": None if stack is None else stack.total_bytes,
        "free_ram_bytes": footprint.free_ram_bytes if stack is not None else None,
        "stack": None if stack is None else to_builtins(stack),
        "groups": [to_builtins(group) for group in footprint.groups],
        "input_buffer_bytes": buffer_bytes or None,
        "endpoints": [{**to_builtins(each), "note": each.note(buffer_bytes)} for each in endpoints],
        "warnings": problems,
    }


def render(title: str, footprint: Footprint, endpoints: Sequence[Endpoint], buffer_bytes: int) -> list[str]:
    """Return the lines of the report."""
    columns = min(shutil.get_terminal_size((80, 24)).columns, MAX_COLUMNS)
    stream = io.StringIO()
    console = Console(
        file=stream, width=columns, force_terminal=sys.stdout.isatty(), highlight=False, emoji=False
    )
    console.print(f"[bold]{title}[/bold] on {footprint.board.title}\n")
    console.print(_totals(footprint))
    console.print()
    console.print(_groups(footprint.groups))
    if endpoints:
        console.print(
            f"\nMessages (the input buffer of the node handle holds messages of up to {buffer_bytes} bytes)"
        )
        console.print(_messages(endpoints, buffer_bytes))
    if footprint.stack is not None:
        console.print(f"\n{_describe_stack(footprint.stack)}", soft_wrap=False)
    return [line.rstrip() for line in stream.getvalue().splitlines()]


def _totals(footprint: Footprint) -> Table:
    table = Table.grid(padding=(0, 2))
    for justify in ("left", "right", "left", "left"):
        table.add_column(justify=justify)
    flash, ram = footprint.board.flash_bytes, footprint.board.ram_bytes
    table.add_row("flash", f"{footprint.flash_bytes:,}", _limit(flash), _bar(footprint.flash_bytes, 0, flash))
    stack = footprint.stack.total_bytes if footprint.stack is not None else 0
    table.add_row("RAM", f"{footprint.ram_bytes:,}", _limit(ram), _bar(footprint.ram_bytes, stack, ram))
    if footprint.stack is not None:
        table.add_row("  stack, at most", f"{stack:,}")
        table.add_row("  free", f"{footprint.free_ram_bytes:,}" if ram else "")
    return table


def _limit(limit: int) -> str:
    return f"of {limit:,} bytes" if limit else "bytes"


def _bar(used: int, more: int, limit: int) -> str:
    if not limit:
        return ""
    cells = min(round(_BAR_CELLS * used / limit), _BAR_CELLS)
    further = min(round(_BAR_CELLS * more / limit), _BAR_CELLS - cells)
    color = "red" if used + more > limit else "green"
    share = f"{100 * used / limit:.0f} %" + (f" + {100 * more / limit:.0f} % stack" if more else "")
    bar = f"[{color}]{'█' * cells}{'▒' * further}[/{color}]{'·' * (_BAR_CELLS - cells - further)}"
    return f"{bar} {share}"


def _groups(groups: Sequence[Group]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    table.add_column("used by", no_wrap=True)
    table.add_column("flash", justify="right")
    table.add_column("RAM", justify="right")
    table.add_column("largest items", overflow="fold")
    for group in groups:
        shown = group.largest[:SHOWN_ITEMS]
        largest = ", ".join(f"{_short(each.name)} {max(each.flash_bytes, each.ram_bytes)}" for each in shown)
        table.add_row(group.name, f"{group.flash_bytes:,}", f"{group.ram_bytes:,}", largest)
    return table


def _messages(endpoints: Sequence[Endpoint], buffer_bytes: int) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    for each in endpoints:
        size = f"{each.smallest_bytes}" if each.is_fixed else f"{each.smallest_bytes} + contents"
        table.add_row(each.role, each.topic or each.name, each.type_name, size, each.note(buffer_bytes))
    return table


def _describe_stack(stack: StackEstimate) -> str:
    names = [_short(each) for each in stack.main_path]
    if len(names) > _MAX_SHOWN_CALLS:
        names = [*names[: _MAX_SHOWN_CALLS - 2], "...", names[-1]]
    lines = [f"Deepest stack: {stack.main_bytes} bytes in {' > '.join(names)}"]
    if stack.interrupt_bytes:
        interrupted = " > ".join(_short(each) for each in stack.interrupt_path[:2])
        lines.append(f"plus {stack.interrupt_bytes} bytes if {interrupted} interrupts it there.")
    if stack.unknown:
        lines.append(f"It can be more: {'; '.join(_short(each) for each in stack.unknown)}.")
    return "\n".join(lines)


def _short(name: str) -> str:
    """Return a name without template arguments, the namespace `ros` and empty parentheses."""
    while (plain := _TEMPLATE.sub("", name)) != name:
        name = plain
    return name.replace("ros::", "").replace("()", "")
