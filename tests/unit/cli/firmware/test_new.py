from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from rostether.cli.firmware import new as new_module
from rostether.cli.firmware.new import new_sensor
from unit.cli.command_shell import Shell


def test_new_writes_a_sketch_and_shows_the_next_step(
    tmp_path: Path, shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = shell.output("new", "sensor", "temperature", "oven", "--pin", "sensor=a2", "--board", "mega")
    assert text.splitlines() == [
        "wrote oven/oven.ino; its first lines show the wiring",
        "next: rostether flash oven --board mega",
    ]
    assert "const int SENSOR = A2;" in (tmp_path / "oven" / "oven.ino").read_text()
    assert "did you mean temperature?" in shell.failure("new", "sensor", "temprature")
    assert "write NAME=PIN" in shell.failure("new", "sensor", "ultrasound", "--pin", "3", code=2)
    shell.output("new", "sensor", "button", "--pin", "3")
    assert "const int BUTTON = 3;" in (tmp_path / "button" / "button.ino").read_text()


def test_on_a_terminal_it_asks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal:
        @staticmethod
        def isatty() -> bool:
            return True

    class System:
        stdin = Terminal

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(new_module, "sys", System)
    result = CliRunner().invoke(new_sensor, [], input="button\n4\nbumper\n")
    assert result.exit_code == 0, result.output
    text = (tmp_path / "button" / "button.ino").read_text()
    assert "const int BUTTON = 4;" in text
    assert '("bumper", &pushed)' in text


def test_without_a_terminal_the_sensor_must_be_named(shell: Shell) -> None:
    assert "name a sensor: ultrasound, infrared" in shell.failure("new", "sensor", code=2)
