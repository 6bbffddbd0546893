"""Flash, static RAM and stack of the examples on an Uno, beside those with the established library."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass

from rostether.codegen.library_source import client_library
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.elf import ElfFile
from rostether.firmware.stack import estimate_stack

# avr-gcc 5.4, -Os -flto, Uno: flash and static RAM in bytes.
ESTABLISHED = {
    "HelloWorld": (9278, 1362),
    "Blink": (9344, 1360),
    "pubsub": (9904, 1468),
    "ServiceServer": (10272, 1548),
    "Logging": (9506, 1412),
    "TimeTF": (12408, 1826),
    "Odom": (13642, 1838),
    "ServoControl": (10514, 1411),
    "Ultrasound": (11338, 1461),
}
# The deepest stack of the established library on a simulated Uno is 127 to 138 bytes.
ESTABLISHED_STACK_BYTES = 132


@dataclass(frozen=True, slots=True)
class Size:
    """One example's sizes, in bytes. The stack is what `rostether firmware size` estimates, at most."""

    example: str
    flash_bytes: int
    ram_bytes: int
    stack_bytes: int

    @property
    def flash_part(self) -> float:
        """Of the established library's."""
        return self.flash_bytes / ESTABLISHED[self.example][0]

    @property
    def ram_part(self) -> float:
        """Of the established library's."""
        return self.ram_bytes / ESTABLISHED[self.example][1]

    @property
    def sum_part(self) -> float:
        """Static RAM and stack, of the established library's."""
        established = ESTABLISHED[self.example][1] + ESTABLISHED_STACK_BYTES
        return (self.ram_bytes + self.stack_bytes) / established


def measure() -> Iterator[Size]:
    """Build the examples and measure them."""
    for name in ESTABLISHED:
        built = asyncio.run(build_sketch(client_library() / "examples" / name, find_board("uno")))
        file = ElfFile.read(built.elf)
        yield Size(name, file.flash_bytes, file.ram_bytes, estimate_stack(file).total_bytes)
