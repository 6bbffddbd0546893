from __future__ import annotations

from math import pi
from pathlib import Path

import pytest

from rostether.errors import BoardError
from rostether.simulation.simavr.simulated_board import SimulatedBoard
from unit.simulation.simavr.programs import build, build_text

pytestmark = pytest.mark.simavr

# A second straight ahead, a turn to the left on the spot, a second backwards, then rest.
ROUTE = """
void turn(int left, int right) {
  digitalWrite(8, left < 0);
  analogWrite(3, abs(left));
  digitalWrite(7, right < 0);
  analogWrite(9, abs(right));
}
void setup() {
  pinMode(3, OUTPUT); pinMode(7, OUTPUT); pinMode(8, OUTPUT); pinMode(9, OUTPUT);
  turn(255, 255); delay(1000);
  turn(-255, 255); delay(500);
  turn(-127, -127); delay(1000);
  turn(0, 0);
}
void loop() {}
"""


async def test_odometry_of_a_route(tmp_path: Path) -> None:
    program = await build_text(tmp_path, ROUTE)
    words = ["wheels speed=0.5,track=0.2"]
    async with await SimulatedBoard.start(
        program, link="none", realtime=False, paused=True, commands=words
    ) as board:
        await board.run("900ms")
        event = await board.ask("wheels", "wheels")
        assert (event["left"], event["right"], event["speed_m_s"], event["turn_rad_s"]) == (1, 1, 0.5, 0)
        await board.run("400ms")
        event = await board.ask("wheels", "wheels")
        assert (event["left"], event["right"], event["speed_m_s"], event["turn_rad_s"]) == (-1, 1, 0, 5)
        await board.run("1500ms")
        event = await board.ask("wheels", "wheels")
        assert event["heading_rad"] == pytest.approx(2.5, abs=0.02)
        # Back a quarter of a meter, against a heading of 2.5 rad.
        assert event["x_m"] == pytest.approx(0.5 + 0.249 * 0.8011, abs=0.01)
        assert event["y_m"] == pytest.approx(-0.249 * 0.5985, abs=0.01)
        assert abs(event["heading_rad"]) <= pi


@pytest.mark.parametrize(
    "settings", ["left=D3", "left=D3/X", "left=A9/D2", "speed=0", "track=nan", "wheel=1"]
)
async def test_invalid_wheels_are_refused(settings: str) -> None:
    async with await SimulatedBoard.start(build("echo"), link="none") as board:
        with pytest.raises(BoardError, match="left=D3/D8"):
            await board.send_command(f"wheels {settings}")
