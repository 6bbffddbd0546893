"""Flash, static RAM and stack of the examples, compared with the established library."""

from __future__ import annotations

import asyncio

from firmware.examples.established import ESTABLISHED, FlashSize, RamSize, flash_sizes, ram_size


def measure_flash(board: str) -> list[FlashSize]:
    """Build the examples for a board and measure their flash."""
    return asyncio.run(flash_sizes(board))


def measure_ram() -> list[RamSize]:
    """Run the examples on a simulated Uno and measure their RAM and stack."""
    return [asyncio.run(ram_size(name)) for name in ESTABLISHED["uno"]]
