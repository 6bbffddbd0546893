"""Hostile frames for a simulated Uno at several baud rates: it neither resets nor becomes silent."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from effort import effort
from firmware.robustness.hostile_frames import NUMBERS, NUMBERS_OUT, HostileFrames
from firmware.robustness.scripted_host import ScriptedHost
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions

SKETCH = Path(__file__).parent / "sketches" / "Target"
# Frames for each baud rate; fewer on slow lines.
BAUDS = {9600: 80, 57600: 320, 115200: 400, 250000: 400, 500000: 400, 1000000: 400}
BATCH = 40
MAX_BYTES = effort(2 * BATCH, thorough=10 * BATCH)
# A gap in a frame lasts 0.2 s; each incomplete frame takes one spin, and callbacks wait for parameters.
QUIET_MS = 500


@pytest.mark.timeout(300)
@pytest.mark.parametrize("baud", BAUDS)
async def test_the_board_works_after_any_frames(baud: int) -> None:
    built = await build_sketch(SKETCH, find_board("uno"), BuildOptions(defines=(f"BAUD={baud}",)))
    host = await ScriptedHost.start(built.elf)
    async with host.board:
        await host.run(200)
        host.send(0)
        assert await host.run(2000, lambda: any(topic_id == 10 for topic_id, _ in host.frames))
        guarded = await host.board.ask("memory guarded", "memory")
        end = guarded["address"] + len(guarded["data"]) // 2
        await host.board.guard(f"{guarded['address']}..{guarded['address'] + 8}")
        await host.board.guard(f"{end - 8}..{end}")
        hostile = HostileFrames(baud)
        for batch in range(min(BAUDS[baud], MAX_BYTES) // BATCH):
            frames = [hostile.next() for _ in range(BATCH)]
            host.send_bytes(b"".join(frames))
            await host.run(sum(map(len, frames)) * 10_000 // baud + QUIET_MS)
            # One of the frames may have ended the connection.
            host.send(0)
            await host.run(60)
            host.frames.clear()
            expected = struct.pack("<h", batch - 7)
            host.send(NUMBERS, expected)
            answered = await host.run(1000, lambda: (NUMBERS_OUT, expected) in host.frames)  # noqa: B023
            assert answered, b"".join(frames).hex()
        assert host.faults() == []
        data = await host.board.memory("guarded")
        assert data[:8] == data[-8:] == b"\x5a" * 8
        assert await host.board.free_stack_bytes() > 100


def test_at_least_two_thousand_frames_are_sent() -> None:
    assert sum(BAUDS.values()) >= 2000
