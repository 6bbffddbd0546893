"""The node on a Cortex-M in qemu, with the kits of the Tiva C, ST and Mbed, and the real bridge."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from firmware.platforms.node_harness import node_harness
from firmware.platforms.programs import NODE, STM32_KITS, compile_for_stm32
from rostether.cli.board.simulated_links import simulated
from rostether.simulation.qemu import QemuBoard
from rostether.transports.address_parser import parse_address
from unit.bridge.lateness import lateness

pytestmark = [pytest.mark.arm, pytest.mark.qemu]


async def test_exchanges_messages_over_its_uart(cortex_m_program: Path) -> None:
    async with (
        node_harness() as harness,
        await QemuBoard.start(cortex_m_program) as board,
        harness.bridge(board.address),
    ):
        await harness.exchange_messages()


@pytest.mark.parametrize("kit", STM32_KITS)
async def test_an_stm32_exchanges_messages_over_usart2(kit: str, library: Path, tmp_path: Path) -> None:
    program = compile_for_stm32(kit, NODE / "embedded.cpp", library, tmp_path / "node.elf")
    async with (
        node_harness() as harness,
        await QemuBoard.start(program, machine="netduinoplus2") as board,
        harness.bridge(board.address),
    ):
        await harness.exchange_messages()


async def test_is_served_by_its_link_address(cortex_m_program: Path) -> None:
    link = parse_address(f"sim:{cortex_m_program}?board=lm3s6965evb&name=tiva")
    async with node_harness() as harness, simulated([link], harness.reporter) as (served,):
        assert served.name == "tiva"
        async with harness.bridge(f"{served}?name=tiva"):
            await harness.exchange_messages()


async def test_reconnects_within_two_seconds_of_a_reset(cortex_m_program: Path) -> None:
    async with (
        node_harness() as harness,
        await QemuBoard.start(cortex_m_program) as board,
        harness.bridge(board.address),
    ):
        # High enough that a smaller number can only come after the reset.
        await harness.wait_for_counts(20)
        before = harness.counts[-1]
        seen = len(harness.counts)
        began_s = time.monotonic()
        await board.reset()
        async with lateness() as late:
            while not any(count < before for count in harness.counts[seen:]):
                await harness.wait_for_counts(1)
        assert time.monotonic() - began_s - late.total_s < 2.0
        await harness.exchange_messages()
