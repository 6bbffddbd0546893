"""`board run --board opencr`: commands on standard input, events on standard output."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from programs import ROSTETHER
from rostether.bridge.reporter import SilentReporter
from rostether.cli.board.simulated_links import simulated
from rostether.errors import ConfigError
from rostether.transports.address_parser import parse_address

pytestmark = pytest.mark.gcc

# At each change of the button, it sets the LED and plays a tone.
SKETCH = """\
void setup() {
  pinMode(BDPIN_LED_USER_1, OUTPUT);
  follow();
}
void loop() { follow(); }
void follow() {
  const bool pushed = getPushButton() & 1;
  if (pushed && digitalRead(BDPIN_LED_USER_1) == HIGH) tone(BDPIN_BUZZER, 440, analogRead(A1));
  digitalWrite(BDPIN_LED_USER_1, pushed ? LOW : HIGH);
}
"""
COMMANDS = """\
pin BDPIN_PUSH_SW_9=1
adc A1=4
battery full
range 9
remote sideways
overload front
pin D13=2
dance
pose
adc A1=1.65
pin PUSH_SW_1=1
"""


@pytest.fixture
def sketch(tmp_path: Path) -> Path:
    file = tmp_path / "follow" / "follow.ino"
    file.parent.mkdir()
    file.write_text(SKETCH)
    return file


@pytest.fixture
def running(sketch: Path) -> Iterator[subprocess.Popen[str]]:
    command = [
        *ROSTETHER,
        "board",
        "run",
        str(sketch),
        "--board",
        "opencr",
        "--watch",
        "LED_USER_1",
        "--json",
    ]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        yield process
        process.kill()


def test_commands_change_the_surroundings_and_print_events(running: subprocess.Popen[str]) -> None:
    assert running.stdin is not None and running.stdout is not None and running.stderr is not None
    ready = json.loads(running.stdout.readline())
    assert (ready["event"], ready["board"]) == ("ready", "opencr")
    assert ready["link"].startswith("/dev/pts/")
    running.stdin.write(COMMANDS)
    running.stdin.flush()
    events = [json.loads(running.stdout.readline()) for _ in range(3)]
    assert [event["event"] for event in events] == ["pose", "tone", "pin"]
    assert (events[0]["x_m"], events[0]["heading_rad"]) == (0, 0)
    assert (events[1]["hertz"], events[1]["length_ms"]) == (440, 512)
    assert (events[2]["pin"], events[2]["level"]) == ("BDPIN_LED_USER_1", 0)
    for reason in (
        "the OpenCR has no pin 'BDPIN_PUSH_SW_9'",
        "4 V is not possible at A1",
        "'full' is not a number",
        "the sonar measures 0.02 to 4 m",
        "remote sideways: the remote control has the buttons",
        "the servos are left and right",
        "D13=2: write 0 or 1",
        "dance: the simulated OpenCR has no such command",
    ):
        assert reason in running.stderr.readline()


@pytest.mark.parametrize(
    ("options", "reason"), [("seed=2", "omit --uart, --seed"), ("servo=D9", "servo: the simulated OpenCR")]
)
async def test_options_of_other_boards_are_refused(sketch: Path, options: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        async with simulated([parse_address(f"sim:{sketch}?board=opencr&{options}")], SilentReporter()):
            pass
