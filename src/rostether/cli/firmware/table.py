"""The report of `firmware size` for people, 80 columns wide."""

from __future__ import annotations

import io
import re
import shutil
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from rostether.firmware.endpoints import Endpoint
    from rostether.firmware.footprint import Footprint, Group, Item
    from rostether.firmware.stack import StackEstimate

# Wider tables are not easier to read.
MAX_COLUMNS = 100
SHOWN_ITEMS = 3
_BAR_CELLS = 20
_TEMPLATE = re.compile(r"<[^<>]*>")
_SHOWN_WAY = 6


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
            f"\nMessages; the input buffer of the node handle holds up to {buffer_bytes} bytes each"
        )
        console.print(_messages(endpoints, buffer_bytes))
    if footprint.stack is not None:
        console.print(f"\n{_describe_stack(footprint.stack)}", soft_wrap=False)
    return [line.rstrip() for line in stream.getvalue().splitlines()]


def _totals(footprint: Footprint) -> Table:
    table = Table.grid(padding=(0, 2))
    for justify in ("left", "right", "left", "left"):
        table.add_column(justify=justify)
    flash, ram = footprint.flash_limit_bytes, footprint.ram_limit_bytes
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
    table.add_column("what takes it", no_wrap=True)
    table.add_column("flash", justify="right")
    table.add_column("RAM", justify="right")
    table.add_column("the largest in it", overflow="fold")
    for group in groups:
        largest = ", ".join(_describe_item(each) for each in group.largest[:SHOWN_ITEMS])
        table.add_row(group.name, f"{group.flash_bytes:,}", f"{group.ram_bytes:,}", largest)
    return table


def _describe_item(item: Item) -> str:
    return f"{_short(item.name)} {max(item.flash_bytes, item.ram_bytes)}"


def _messages(endpoints: Sequence[Endpoint], buffer_bytes: int) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    for each in endpoints:
        size = f"{each.smallest_bytes}" if each.is_fixed else f"{each.smallest_bytes} + contents"
        table.add_row(each.role, each.topic or each.name, each.type_name, size, each.note(buffer_bytes))
    return table


def _describe_stack(stack: StackEstimate) -> str:
    names = [_short(each) for each in stack.way]
    if len(names) > _SHOWN_WAY:
        names = [*names[: _SHOWN_WAY - 2], "...", names[-1]]
    lines = [f"Deepest stack: {stack.main_bytes} bytes in {' > '.join(names)}"]
    if stack.interrupt_bytes:
        interrupted = " > ".join(_short(each) for each in stack.interrupt_way[:2])
        lines.append(f"plus {stack.interrupt_bytes} bytes if {interrupted} interrupts it there.")
    if stack.unknown:
        lines.append(f"It can be more: {'; '.join(_short(each) for each in stack.unknown)}.")
    return "\n".join(lines)


def _short(name: str) -> str:
    """Return a name without template arguments and our namespace."""
    while (plain := _TEMPLATE.sub("", name)) != name:
        name = plain
    return name.replace("ros::", "").replace("(anonymous namespace)::", "").replace("()", "")
