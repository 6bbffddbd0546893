from __future__ import annotations

from pathlib import Path

import pytest

from rostether.errors import BoardError
from unit.simulation.simavr.conftest import Start
from unit.simulation.simavr.programs import build, build_text
from unit.simulation.simavr.readings import named

pytestmark = pytest.mark.simavr

EACH_PIN = """
void setup() {
  for (int i = 0; i < NUM_DIGITAL_PINS; i++) pinMode(i, OUTPUT);
  for (int i = 0; i < NUM_DIGITAL_PINS; i++) { digitalWrite(i, HIGH); digitalWrite(i, LOW); }
}
void loop() {}
"""
INPUTS = """
void setup() {
  pinMode(7, INPUT_PULLUP); pinMode(8, INPUT);
  pinMode(3, OUTPUT); pinMode(4, OUTPUT); pinMode(5, OUTPUT);
  attachInterrupt(digitalPinToInterrupt(2), [] { digitalWrite(5, !digitalRead(5)); }, FALLING);
}
void loop() { digitalWrite(3, digitalRead(7)); digitalWrite(4, digitalRead(8)); }
"""


@pytest.mark.parametrize(
    ("kind", "digital", "analog"), [("uno", 14, 6), ("nano", 14, 6), ("mega", 54, 16), ("leonardo", 18, 6)]
)
async def test_pins_are_where_arduino_has_them(
    start: Start, tmp_path: Path, kind: str, digital: int, analog: int
) -> None:
    names = [*(f"D{number}" for number in range(digital)), *(f"A{number}" for number in range(analog))]
    board = await start(
        await build_text(tmp_path, EACH_PIN, board=kind), *(f"watch {name}" for name in names), board=kind
    )
    await board.run("20ms")
    rose = [event["pin"] for event in named(board, "pin") if event["level"]]
    assert rose[: len(names)] == names


async def test_inputs_read_the_levels_from_outside(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, INPUTS), "pin D7=0 D8=1")
    await board.run("2ms")
    assert [await board.pin_level(pin) for pin in ("D3", "D4")] == [False, True]
    await board.drive_pin("D7", True)
    await board.drive_pin("8", False)
    await board.run("2ms")
    assert [await board.pin_level(pin) for pin in ("D3", "D4")] == [True, False]
    # After the release, one pin has its pull-up and the other has none.
    await board.drive_pin("D7", False)
    await board.drive_pin("D7", None)
    await board.drive_pin("D8", None)
    await board.run("2ms")
    assert [await board.pin_level(pin) for pin in ("D3", "D4")] == [True, False]


async def test_a_falling_edge_interrupts(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, INPUTS), "pin D2=1")
    await board.run("2ms")
    assert not await board.pin_level("D5")
    await board.drive_pin("D2", False)
    await board.run("1ms")
    assert await board.pin_level("D5")
    await board.drive_pin("D2", True)
    await board.run("1ms")
    assert await board.pin_level("D5")


async def test_a_reset_releases_outputs(start: Start, tmp_path: Path) -> None:
    sketch = "void setup() { delay(5); pinMode(13, OUTPUT); digitalWrite(13, HIGH); }\nvoid loop() {}\n"
    board = await start(await build_text(tmp_path, sketch), "watch D13")
    await board.run("10ms")
    await board.reset()
    await board.power(False)
    await board.power(True)
    await board.run("10ms")
    assert [event["level"] for event in named(board, "pin")] == [0, 1, 0, 1]


async def test_unwatched_pins_are_not_reported(start: Start, tmp_path: Path) -> None:
    board = await start(await build_text(tmp_path, EACH_PIN), "watch D3 D4", "unwatch D3")
    await board.run("20ms")
    assert {event["pin"] for event in named(board, "pin") if event["level"]} == {"D4"}


@pytest.mark.parametrize(
    "words",
    ["pin D99=1", "pin D7=2", "pin D7=", "watch A9", "watch B5", "adc D3=1", "adc A0=6", "adc A0", "servo X"],
)
async def test_invalid_commands_are_reported_in_one_line(start: Start, words: str) -> None:
    board = await start(build("echo"))
    with pytest.raises(BoardError) as raised:
        await board.send_command(words)
    assert str(raised.value).startswith(f"{words}: ")
    assert "\n" not in str(raised.value)


async def test_a_nanos_last_inputs_are_analog_only(start: Start) -> None:
    board = await start(build("echo"), "adc A7=1", board="nano")
    with pytest.raises(BoardError, match="only an analog input"):
        await board.send_command("watch A7")
