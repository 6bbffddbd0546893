"""The node on an RP2040, the chip of the Pico, in the emulator rp2040js, with the real bridge."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.platforms.node_harness import node_harness
from firmware.platforms.programs import NODE, compile_for_rp2040
from interop_web.web_peers import WebPeers, packages_or_skip


@pytest.mark.arm
@pytest.mark.web
@pytest.mark.timeout(240)
async def test_exchanges_messages_over_its_uart(library: Path, tmp_path: Path) -> None:
    image = compile_for_rp2040(NODE / "arduino.cpp", library, tmp_path / "node.bin")
    peers = WebPeers(packages_or_skip(), tmp_path / "peers")
    try:
        async with node_harness() as harness, harness.bridge("tcp://127.0.0.1:0") as listening:
            host, _, port = listening[0].removeprefix("tcp://").partition(":")
            await peers.start("rp2040_board.mjs", str(image), host, port)
            await harness.exchange_messages()
    finally:
        await peers.close()
