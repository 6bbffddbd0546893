"""A board that sleeps in loop() is not regarded as reset; a board that was reset is detected."""

from __future__ import annotations

from pathlib import Path

import pytest

from effort import effort
from rostether.firmware.build import build_sketch, find_board
from rostether.firmware.built_firmware import BuildOptions
from rostether.rosserial.events import DeviceReset, HostEvent, TimeRequested
from rostether.rosserial.host_link import HostLink
from rostether.rostime import Time
from rostether.simulation.simavr.simulated_board import SimulatedBoard

SKETCH = Path(__file__).parent / "sketches" / "SlowLoop"
STEP_S = 0.02


class LinkedBoard:
    """A board and a host link; both have the same time."""

    def __init__(self, board: SimulatedBoard) -> None:
        self.board = board
        self.link = HostLink()
        self.now_s = 0.0
        self.resets_s: list[float] = []

    async def run(self, duration_s: float) -> None:
        end_s = self.now_s + duration_s
        while self.now_s < end_s:
            if data := self.link.data_to_send():
                await self.board.send(data)
            await self.board.run(f"{round(STEP_S * 1000)}ms")
            self.now_s += STEP_S
            data = bytes(self.board.serial)
            self.board.serial.clear()
            events: list[HostEvent] = self.link.receive_data(data, self.now_s) if data else []
            for event in events + self.link.handle_timer(self.now_s):
                if isinstance(event, TimeRequested):
                    self.link.answer_time(Time.from_s(1_700_000_000 + self.now_s), self.now_s)
                elif isinstance(event, DeviceReset):
                    self.resets_s.append(self.now_s)


@pytest.mark.parametrize("loop_ms", [200, 1000, 2000])
async def test_a_slow_loop_is_not_a_reset(loop_ms: int) -> None:
    built = await build_sketch(SKETCH, find_board("uno"), BuildOptions(defines=(f"LOOP_MS={loop_ms}",)))
    for host_starts_s in effort((0.35,), thorough=(0.0, 0.35, 1.2)):
        board = await SimulatedBoard.start(
            built.elf, link="none", realtime=False, paused=True, commands=["watch serial"]
        )
        async with board:
            linked = LinkedBoard(board)
            await linked.run(host_starts_s)
            linked.link.start(linked.now_s)
            await linked.run(12.0)
            # A board that spins every 2 s may be silent for 4 s; after 3 s the host requests its topics
            # again.
            for _ in range(round(4.0 / STEP_S)):
                if linked.link.is_settled:
                    break
                await linked.run(STEP_S)
            assert linked.link.is_settled
            assert linked.resets_s == []
            await board.reset()
            reset_s = linked.now_s
            await linked.run(6.0)
            (detected_s,) = linked.resets_s
            # The host may regard its first time request as a late one, but not that of its next loop().
            assert detected_s - reset_s < max(2.0, loop_ms / 1000 + 0.5)
