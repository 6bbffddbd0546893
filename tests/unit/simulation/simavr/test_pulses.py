from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build_text
from unit.simulation.simavr.readings import named

pytestmark = pytest.mark.simavr

PWM_PINS = {
    "uno": (3, 5, 6, 9, 10, 11),
    "mega": (*range(2, 14), 44, 45, 46),
    "leonardo": (3, 5, 9, 10, 11),
}
ANALOG_WRITE = """
void setup() { for (int i = 2; i < NUM_DIGITAL_PINS; i++) if (digitalPinHasPWM(i)) analogWrite(i, 64); }
void loop() {}
"""
SERVOS = """
#include <Servo.h>
Servo first, second;
void setup() {
  first.attach(9); second.attach(4);
  first.write(90); second.write(10);
  delay(200);
  first.write(135);
}
void loop() {}
"""
TIMER_SERVO = """
void setup() {
  pinMode(9, OUTPUT);
  ICR1 = 39999; OCR1A = 1999;
  TCCR1A = 1 << COM1A1 | 1 << WGM11; TCCR1B = 1 << WGM13 | 1 << WGM12 | 1 << CS11;
}
void loop() {}
"""


@pytest.mark.parametrize("kind", PWM_PINS)
async def test_analog_write(start: Start, tmp_path: Path, kind: str) -> None:
    pins = [f"D{pin}" for pin in PWM_PINS[kind]]
    program = await build_text(tmp_path, ANALOG_WRITE, board=kind)
    board = await start(program, *(f"watch {pin}" for pin in pins), board=kind)
    await board.run("10ms")
    reported = {event["pin"]: event for event in named(board, "pwm")}
    assert set(reported) == set(pins)
    for event in reported.values():
        assert event["duty"] == pytest.approx(64 / 255, abs=0.004)
        assert event["period_us"] in (1024.0, 2040.0)
    # The effect of a timer is reported as PWM, not as changes of a pin.
    assert not [event for event in named(board, "pin") if event["level"]]


async def test_pwm_ends(start: Start, tmp_path: Path) -> None:
    sketch = (
        "void setup() { analogWrite(9, 128); delay(20); analogWrite(9, 255); delay(20); }\nvoid loop() {}\n"
    )
    board = await start(await build_text(tmp_path, sketch), "watch D9")
    await board.run("60ms")
    assert [(event["timer"], round(event["duty"], 2)) for event in named(board, "pwm")] == [
        (True, 0.5),
        (False, 1),
    ]
    assert await board.pin_level("D9")


@pytest.mark.parametrize("kind", ["uno", "mega", "leonardo"])
async def test_servo_pulses_made_by_software(start: Start, tmp_path: Path, kind: str) -> None:
    board = await start(await build_text(tmp_path, SERVOS, board=kind), "servo D9", "servo D4", board=kind)
    await board.run("150ms")
    assert await board.servo_angle("D9") == pytest.approx(90, abs=1)
    assert await board.servo_angle("D4") == pytest.approx(10, abs=1)
    await board.run("150ms")
    assert await board.servo_angle("D9") == pytest.approx(135, abs=1)
    assert await board.servo_pulse_us("D9") == pytest.approx(544 + 135 * (2400 - 544) / 180, abs=10)


async def test_only_changes_of_a_degree_are_reported(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, SERVOS), "servo D9")
    await board.run("300ms")
    angles = [event["angle_deg"] for event in named(board, "servo") if event["pin"] == "D9"]
    assert len(angles) >= 2
    assert all(abs(now - before) > 0.9 for before, now in pairwise(angles))


async def test_servo_pulses_made_by_a_timer(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, TIMER_SERVO), "servo D9")
    await board.run("50ms")
    assert await board.servo_pulse_us("D9") == pytest.approx(1000)
