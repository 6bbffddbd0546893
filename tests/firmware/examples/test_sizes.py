"""What the examples take of an Uno, beside the same ones with the established library."""

from __future__ import annotations

import asyncio

import pytest

from firmware.examples.stage import build_example
from rostether.firmware.elf import ElfFile

# Flash and static RAM in bytes with the established library: avr-gcc 5.4, -Os -flto, Uno.
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
    "MeArm": (10578, 1442),
}
MOST_FLASH, MOST_RAM = 0.65, 0.50


async def test_examples_are_small(capsys: pytest.CaptureFixture[str]) -> None:
    built = await asyncio.gather(*(build_example(name, "uno") for name in ESTABLISHED))
    lines, too_large = [f"{'Uno':<16}{'flash':>7}{'':>7}{'RAM':>7}"], []
    for each in built:
        name = each.sketch.name
        file = ElfFile.read(each.elf)
        flash, ram = file.flash_bytes / ESTABLISHED[name][0], file.ram_bytes / ESTABLISHED[name][1]
        lines.append(f"{name:<16}{file.flash_bytes:>7}{flash:>7.1%}{file.ram_bytes:>7}{ram:>7.1%}")
        if flash > MOST_FLASH or ram > MOST_RAM:
            too_large.append(lines[-1])
    with capsys.disabled():
        print("\n" + "\n".join(lines))
    assert not too_large, f"of the established library's: at most {MOST_FLASH:.0%} and {MOST_RAM:.0%}"
