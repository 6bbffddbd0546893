"""`board run` as a process: its output, its input and its end."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
from pathlib import Path

import pytest

from programs import ROSTETHER, read_until, running
from unit.simulation.simavr.programs import build

pytestmark = pytest.mark.simavr

RUN = ("board", "run")


def run_to_end(*arguments: str, words: str = "") -> subprocess.CompletedProcess[str]:
    result = subprocess.run(
        [*ROSTETHER, *RUN, *arguments], input=words, capture_output=True, text=True, timeout=120
    )
    result.stderr = without_wait(result.stderr)
    return result


def without_wait(errors: str) -> str:
    """Return the lines of stderr without the line about a long preparation, which a busy machine adds."""
    return "".join(
        line for line in errors.splitlines(keepends=True) if not line.startswith("preparing a simulated ")
    )


def test_it_lists_its_boards_and_ends_on_request() -> None:
    result = run_to_end(str(build("tick")), "--for", "30ms", "--watch", "D13")
    lines = result.stdout.splitlines()
    assert lines[0].startswith(f"uno (atmega328p) runs {build('tick')}; serial port /dev/pts/")
    assert lines[1] == "    0.000000  pin D13 level=0 output=no"
    assert lines[2] == "    0.000000  reset cause=power"
    assert lines[-1].startswith("    0.030000  stopped cycles=48000")
    assert (result.returncode, result.stderr) == (0, "")


def test_without_a_clock_as_json() -> None:
    result = run_to_end(str(build("tick")), "--fast", "--for", "20s", "--json")
    events = [json.loads(line) for line in result.stdout.splitlines()]
    assert [event["event"] for event in events] == ["ready", "reset", "stopped"]
    assert events[0]["mcu"] == "atmega328p"
    assert events[-1]["time_s"] == pytest.approx(20)


def test_lines_of_input_are_words() -> None:
    words = "memory ticks\n\n  cycles\nnonsense\nadc A0=9\nquit\n"
    result = run_to_end(str(build("tick")), "--json", words=words)
    assert result.returncode == 0
    names = [json.loads(line)["event"] for line in result.stdout.splitlines()]
    # On a busy machine the board may be behind.
    assert [each for each in names if each != "behind"] == ["ready", "reset", "memory", "cycles"]
    errors = result.stderr.splitlines()
    assert errors[0].startswith("rostether: error: nonsense: no such command; the commands are adc aref ")
    assert errors[1].startswith("rostether: error: adc A0=9: write volts from 0 to 5.5")
    assert len(errors) == 2


def test_the_end_of_input_does_not_end_it(tmp_path: Path) -> None:
    lines = tmp_path / "words"
    lines.write_text("watch D13")
    with (
        lines.open() as given,
        running(*RUN, str(build("tick")), "--for", "2s", stdin=given.fileno()) as process,
    ):
        stdout, _ = process.communicate(timeout=60)
    assert "pin D13 level=0" in stdout
    assert "stopped" in stdout
    assert process.returncode == 0


@pytest.mark.parametrize(("sign", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 0)])
def test_signals_end_it_quietly(tmp_path: Path, sign: signal.Signals, code: int) -> None:
    link = tmp_path / "board"
    with running(*RUN, str(build("tick")), "--link", str(link), stdin=subprocess.PIPE) as process:
        assert f"linked at {link}" in read_until(process, "serial port")[-1]
        assert link.is_symlink()
        process.send_signal(sign)
        assert process.wait(60) == code
        assert process.stderr is not None
        assert without_wait(process.stderr.read()) == ""
    assert not link.is_symlink()


def test_lines_typed_in_a_terminal() -> None:
    leader, follower = pty.openpty()
    try:
        with running(*RUN, str(build("tick")), stdin=follower) as process:
            read_until(process, "reset cause=power")
            os.write(leader, b"cycles\n")
            assert "cycles=" in read_until(process, "cycles ")[-1]
            # The terminal's mode is unchanged: for a program that shares it, it must not be non-blocking.
            assert os.get_blocking(follower)
    finally:
        os.close(leader)
        os.close(follower)


def test_a_reader_that_stops_early_ends_it() -> None:
    command = f"{' '.join((*ROSTETHER, *RUN))} {build('tick')} --watch serial --json | head -n 3"
    result = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, timeout=120
    )
    assert (result.returncode, result.stderr) == (0, "")
    assert len(result.stdout.splitlines()) == 3


def test_options_are_words_for_the_board() -> None:
    options = ["--adc", "A0=1.5", "--adc", "A1=2", "--pin", "D7=1", "--range", "none", "--attitude", "1 2 3"]
    options += ["--servo", "D9", "--fault", "flip=0.1,seed=2", "--guard", "ticks", "--autoreset"]
    options += ["--hcsr04", "trig=D8,echo=D7", "--network", "localhost:1", "--seed", "3", "--tcp", "0"]
    result = run_to_end(str(build("tick")), *options, "--for", "20ms")
    assert (result.returncode, result.stderr) == (0, "")
    assert "serial port tcp://127.0.0.1:" in result.stdout
    assert "guarded write" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "code", "reported"),
    [
        (["missing.elf"], 1, "missing.elf does not exist; give a sketch"),
        (["missing.ino"], 1, "missing.ino does not exist; give a sketch"),
        (["ELF", "--board", "due"], 1, "micro, opencr, lm3s6965evb, netduinoplus2"),
        (["ELF", "--board", "mega"], 1, "built for another chip"),
        (["ELF", "--watch", "D77"], 1, "watch D77: this board has no such pin"),
        (["ELF", "--for", "soon"], 1, "for soon: write how long to run"),
        (["ELF", "--link", "x", "--tcp", "1"], 2, "give --link or --tcp, not both"),
        ([], 2, "PROGRAM"),
    ],
)
def test_mistakes_are_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], code: int, reported: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run_to_end(*(str(build("tick")) if each == "ELF" else each for each in arguments))
    assert result.returncode == code
    assert reported in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert result.stdout == ""


def test_a_sketch_is_built_first(tmp_path: Path) -> None:
    sketch = tmp_path / "Hello.ino"
    sketch.write_text('void setup() { Serial.begin(9600); Serial.print("hi"); }\nvoid loop() {}\n')
    result = run_to_end(str(sketch), "--fast", "--for", "50ms", "--json", "--watch", "serial")
    sent = [json.loads(line).get("data", "") for line in result.stdout.splitlines()]
    assert bytes.fromhex("".join(sent)) == b"hi"


def test_text_is_shown_by_line(tmp_path: Path) -> None:
    sketch = tmp_path / "Hello.ino"
    sketch.write_text(
        'void setup() { Serial.begin(9600); Serial.print("t=21\\n\\nready> "); Serial.flush(); delay(300); '
        'Serial.print("on"); Serial.write(255); }\nvoid loop() {}\n'
    )
    result = run_to_end(str(sketch), "--duration", "0.5", "--watch", "serial")
    shown = [line.partition("serial ")[2] for line in result.stdout.splitlines() if "  serial " in line]
    assert shown == [r'data="t=21\n"', r'data="\n"', 'data="ready> "', 'data="on"', "data=ff"]


@pytest.mark.parametrize(
    ("duration", "cycles"), [("0.001", 16000), ("1ms", 16000), ("16000 cycles", 16000), ("1", 16000000)]
)
def test_units_of_the_duration(duration: str, cycles: int) -> None:
    result = run_to_end(str(build("tick")), "--fast", "--duration", duration, "--json")
    assert json.loads(result.stdout.splitlines()[-1])["cycles"] == pytest.approx(cycles, abs=10)


def test_a_sketch_that_does_not_compile_shows_why(tmp_path: Path) -> None:
    sketch = tmp_path / "Wrong.ino"
    sketch.write_text("void setup() { wrong(); }\nvoid loop() {}\n")
    result = run_to_end(str(sketch))
    assert result.returncode == 1
    assert "Wrong.ino" in result.stderr
    assert "wrong" in result.stderr
    assert "rostether: error: " in result.stderr.splitlines()[-1]
