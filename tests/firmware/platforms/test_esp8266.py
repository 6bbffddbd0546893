"""The node on the processor core of an ESP8266 in qemu, built with its compiler, with the real bridge."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.platforms.node_harness import node_harness
from firmware.platforms.programs import NODE, compile_for_esp8266, running

QEMU = (
    "qemu-system-xtensa",
    "-machine",
    "lx60-nommu",
    "-cpu",
    "lx106",
    "-display",
    "none",
    "-monitor",
    "none",
    # The program's clock counts instructions as 1 ns, so that a busy machine does not cause a gap in a frame.
    "-icount",
    "shift=0",
)


@pytest.mark.lx106
async def test_exchanges_messages_over_its_serial_port(library: Path, tmp_path: Path) -> None:
    program = compile_for_esp8266(NODE / "arduino.cpp", library, tmp_path / "node.elf")
    async with node_harness() as harness, harness.bridge("tcp://127.0.0.1:0") as listening:
        host = listening[0].removeprefix("tcp://")
        async with running(*QEMU, "-serial", f"tcp:{host}", "-kernel", str(program)):
            await harness.exchange_messages()
