"""Flash, static RAM and stack of the examples, compared with the established library."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass

from firmware.examples.established import (
    ESTABLISHED,
    ESTABLISHED_STACK_BYTES,
    FlashSize,
    flash_sizes,
)
from rostether.codegen.library_source import client_library
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.firmware.stack import estimate_stack


@dataclass(frozen=True, slots=True)
class Size:
    """One example's memory on an Uno, in bytes. The stack is what `rostether firmware size` estimates."""

    example: str
    ram_bytes: int
    stack_bytes: int

    @property
    def sum_part(self) -> float:
        """Static RAM and stack, relative to those with the established library."""
        established = ESTABLISHED["uno"][self.example][1] + ESTABLISHED_STACK_BYTES
        return (self.ram_bytes + self.stack_bytes) / established


def measure_flash(board: str) -> list[FlashSize]:
    """Build the examples for a board and measure their flash."""
    return asyncio.run(flash_sizes(board))


def measure() -> Iterator[Size]:
    """Build the examples for an Uno and measure their RAM."""
    for name in ESTABLISHED["uno"]:
        built = asyncio.run(build_sketch(client_library() / "examples" / name, find_board("uno")))
        file = ElfFile.read(built.elf)
        yield Size(name, file.ram_bytes, estimate_stack(file).total_bytes)
