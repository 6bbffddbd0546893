"""The node on a Cortex-M in qemu, with the headers of the Tiva C and of ST's HAL, through the real bridge."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from firmware.platforms.meeting import meeting
from rostether.cli.board.simulated_links import simulated
from rostether.simulation.qemu import QemuBoard
from rostether.transports.address_parser import parse_address
from unit.bridge.lateness import lateness

pytestmark = [pytest.mark.arm, pytest.mark.qemu]


async def test_converses_over_its_uart(cortex_m_program: Path) -> None:
    async with (
        meeting() as met,
        await QemuBoard.start(cortex_m_program) as board,
        met.bridge(board.address),
    ):
        await met.converse()


async def test_an_stm32_converses_over_usart2_and_comes_back_after_a_reset(stm32_program: Path) -> None:
    async with (
        meeting() as met,
        await QemuBoard.start(stm32_program, machine="netduinoplus2") as board,
        met.bridge(board.address),
    ):
        await met.converse()
        await met.counting(20)
        before, seen = met.counts[-1], len(met.counts)
        await board.reset()
        while not any(count < before for count in met.counts[seen:]):
            await met.counting(1)


async def test_is_served_by_its_link_address(cortex_m_program: Path) -> None:
    link = parse_address(f"sim:{cortex_m_program}?board=lm3s6965evb&name=tiva")
    async with meeting() as met, simulated([link], met.reporter) as (served,):
        assert served.name == "tiva"
        async with met.bridge(f"{served}?name=tiva"):
            await met.converse()


async def test_comes_back_within_two_seconds_of_a_reset(cortex_m_program: Path) -> None:
    async with (
        meeting() as met,
        await QemuBoard.start(cortex_m_program) as board,
        met.bridge(board.address),
    ):
        # Far enough that a smaller number can only come after the reset.
        await met.counting(20)
        before = met.counts[-1]
        seen = len(met.counts)
        began_s = time.monotonic()
        await board.reset()
        async with lateness() as late:
            while not any(count < before for count in met.counts[seen:]):
                await met.counting(1)
        assert time.monotonic() - began_s - late.total_s < 2.0
        await met.converse()
