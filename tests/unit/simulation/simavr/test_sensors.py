from __future__ import annotations

from math import cos, radians, sin
from pathlib import Path

import pytest

from rostether.errors import BoardError
from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build, build_text
from unit.simulation.simavr.readings import number, words16

pytestmark = pytest.mark.simavr

ANALOG = """
volatile int values[16], internal;
void setup() {
  for (int i = 0; i < NUM_ANALOG_INPUTS; i++) values[i] = analogRead(i);
#ifdef INTERNAL
  analogReference(INTERNAL); internal = analogRead(0);
#endif
}
void loop() {}
"""
SONAR = """
volatile unsigned long timed, pulse;
void trigger() {
  digitalWrite(6, LOW); delayMicroseconds(2);
  digitalWrite(6, HIGH); delayMicroseconds(10);
  digitalWrite(6, LOW);
}
void setup() { pinMode(6, OUTPUT); pinMode(5, INPUT); }
void loop() {
  trigger(); pulse = pulseIn(5, HIGH, 40000); delay(5);
  trigger();
  unsigned long rose = micros();
  while (!digitalRead(5) && micros() - rose < 2000) continue;
  rose = micros();
  while (digitalRead(5)) continue;
  timed = micros() - rose;
  delay(5);
}
"""
IMU = """
#include <Wire.h>
volatile int16_t motion[7], field[3];
volatile uint8_t who, who_field, without_bypass, error, ready_early, ready_late, asleep;
volatile uint8_t accel_range, gyro_range;
uint8_t read(uint8_t device, uint8_t at, uint8_t* bytes, uint8_t count) {
  Wire.beginTransmission(device);
  Wire.write(at);
  uint8_t failure = Wire.endTransmission(false);
  if (failure) return failure;
  Wire.requestFrom(device, count);
  for (uint8_t i = 0; i < count; i++) bytes[i] = Wire.read();
  return 0;
}
void write(uint8_t device, uint8_t at, uint8_t byte) {
  Wire.beginTransmission(device); Wire.write(at); Wire.write(byte); Wire.endTransmission();
}
void setup() {
  uint8_t bytes[14];
  Wire.begin();
  Wire.setClock(400000);
  read(0x68, 0x75, bytes, 1); who = bytes[0];
  without_bypass = read(0x0c, 0, bytes, 1);
  read(0x68, 0x3b, bytes, 14); for (uint8_t i = 0; i < 14; i++) asleep |= bytes[i];
  write(0x68, 0x6b, 0);
  write(0x68, 0x37, 2);
  read(0x0c, 0, bytes, 1); who_field = bytes[0];
}
void loop() {
  uint8_t bytes[14];
  write(0x68, 0x1c, accel_range << 3);
  write(0x68, 0x1b, gyro_range << 3);
  error = read(0x68, 0x3b, bytes, 14);
  for (uint8_t i = 0; i < 7; i++) motion[i] = (int16_t)(bytes[2 * i] << 8 | bytes[2 * i + 1]);
  write(0x0c, 0x0a, 1);
  read(0x0c, 2, bytes, 1); ready_early = bytes[0];
  delay(9);
  read(0x0c, 2, bytes, 1); ready_late = bytes[0];
  read(0x0c, 3, bytes, 7);
  for (uint8_t i = 0; i < 3; i++) field[i] = (int16_t)(bytes[2 * i + 1] << 8 | bytes[2 * i]);
}
"""


@pytest.mark.parametrize(("kind", "inputs"), [("uno", 6), ("mega", 16), ("leonardo", 12)])
async def test_volts_are_what_analog_read_returns(
    start: Start, tmp_path: Path, kind: str, inputs: int
) -> None:
    volts = [0.1 + 0.31 * index for index in range(inputs)]
    words = [f"adc A{index}={value:.3f}" for index, value in enumerate(volts)]
    board = await start(await build_text(tmp_path, ANALOG, board=kind), *words, board=kind)
    await board.run("20ms")
    values = await words16(board, "values")
    assert values[:inputs] == [int(value / 5 * 1024 + 1e-9) for value in volts]
    if kind == "uno":
        assert await number(board, "internal") == int(0.1 / 1.1 * 1024)


async def test_volts_beyond_the_reference_read_the_maximum(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, ANALOG), "adc A0=5.0 A1=5.5 A2=2.5")
    await board.run("20ms")
    assert (await words16(board, "values"))[:3] == [1023, 1023, 512]
    assert await number(board, "internal") == 1023


@pytest.mark.parametrize("meters", [0.02, 0.5, 1.0, 2.0, 3.2])
async def test_an_echo_has_the_set_distance(start: Start, tmp_path: Path, meters: float) -> None:
    board = await start(await build_text(tmp_path, SONAR), f"range {meters}")
    await board.run("200ms")
    for name in ("pulse", "timed"):
        assert await number(board, name) / 58.3 / 100 == pytest.approx(meters, abs=0.01)


@pytest.mark.parametrize("distance", ["none", "0.01", "4.1"])
async def test_no_echo_without_an_obstacle(start: Start, tmp_path: Path, distance: str) -> None:
    board = await start(await build_text(tmp_path, SONAR), f"range {distance}")
    await board.run("200ms")
    assert await number(board, "pulse") == 0
    await board.set_range(0.3)
    await board.run("200ms")
    assert await number(board, "pulse") / 58.3 / 100 == pytest.approx(0.3, abs=0.01)


async def test_an_hcsr04_on_other_pins(start: Start, tmp_path: Path) -> None:
    sketch = SONAR.replace("(6,", "(8,").replace("(5", "(7")
    board = await start(await build_text(tmp_path, sketch), "hcsr04 trig=D8,echo=D7", "range 1")
    await board.run("100ms")
    assert await number(board, "pulse") / 58.3 / 100 == pytest.approx(1, abs=0.01)


async def test_the_imu_measures_the_attitude_of_the_board(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, IMU), "attitude 10 20 30")
    await board.run("60ms")
    bytes_read = [await number(board, name) for name in ("who", "who_field", "error", "asleep")]
    assert bytes_read == [0x68, 0x48, 0, 0]
    assert await number(board, "without_bypass") != 0
    assert (await number(board, "ready_early"), await number(board, "ready_late")) == (0, 1)
    roll, pitch = radians(10), radians(20)
    x, y, z, temperature, *turning = await words16(board, "motion")
    gravity = (-sin(pitch), cos(pitch) * sin(roll), cos(pitch) * cos(roll))
    assert (x / 16384, y / 16384, z / 16384) == pytest.approx(gravity, abs=1e-4)
    assert temperature / 340 + 35 == pytest.approx(25, abs=0.1)
    assert turning == [0, 0, 0]


@pytest.mark.parametrize("setting", [0, 1, 2, 3])
async def test_the_imus_ranges(start: Start, tmp_path: Path, setting: int) -> None:
    ranges = f"accel_range = {setting}, gyro_range = {setting};"
    program = await build_text(tmp_path, IMU.replace("accel_range, gyro_range;", ranges))
    board = await start(program, "attitude 0 0 0")
    await board.set_attitude(0, 0, radians(90), over_s=2)
    await board.run("100ms")
    motion = await words16(board, "motion")
    assert motion[2] == pytest.approx(16384 / 2**setting, abs=1)
    assert motion[6] == pytest.approx(45 * 131 / 2**setting, abs=1)


@pytest.mark.parametrize("yaw", [0, 90, -135])
async def test_the_magnetometer_points_north(start: Start, tmp_path: Path, yaw: int) -> None:
    board = await start(await build_text(tmp_path, IMU), f"attitude 0 0 {yaw}")
    await board.run("60ms")
    # Its axes differ: x is the board's y, y the board's x, z down; 0.3 µT a step.
    y, x, down = (value * 0.3 for value in await words16(board, "field"))
    assert (x, y) == pytest.approx((20 * cos(radians(yaw)), -20 * sin(radians(yaw))), abs=0.3)
    assert down == pytest.approx(44, abs=0.3)


@pytest.mark.parametrize(
    "words",
    ["attitude 1 2", "attitude a b c", "attitude 1 2 3 over 2", "range far", "hcsr04 trig=D6", "aref 9"],
)
async def test_invalid_commands_are_reported(start: Start, words: str) -> None:
    board = await start(build("echo"))
    with pytest.raises(BoardError):
        await board.send_command(words)
