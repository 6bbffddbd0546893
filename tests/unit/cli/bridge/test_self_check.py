from __future__ import annotations

import json
from pathlib import Path

import pytest

from rostether.cli.bridge import self_check
from unit.cli.command_shell import Shell


def test_missing_parts_come_with_the_next_step(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    program = tmp_path / "arduino-cli"
    program.write_text("")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(self_check, "find_spec", lambda _name: None)
    monkeypatch.setattr(self_check, "_EXTRAS", self_check._EXTRAS[:1])
    found = {
        each["part"]: each for each in map(json.loads, shell.output("self-check", "--json").splitlines())
    }
    assert found["arduino-cli"]["works"]
    assert found["arduino-cli"]["found"] == str(program)
    assert not found["zenoh"]["works"]
    assert "rostether[zenoh]" in found["zenoh"]["next_step"]
    assert "avr-gcc" in found["avr-gcc"]["next_step"]
    assert "libsimavr-dev" in found["simavr"]["next_step"]
    assert all(each["works"] or each["next_step"] for each in found.values())
    lines = shell.output("self-check").splitlines()
    assert any(line.startswith("no   zenoh") for line in lines)


def test_a_group_that_cannot_be_joined(shell: Shell, monkeypatch: pytest.MonkeyPatch) -> None:
    # Not a multicast group.
    monkeypatch.setattr("rostether.platform.multicast_socket.REFERENCE_GROUP", "10.0.0.1")
    assert "     cannot join 10.0.0.1: Invalid argument; connect this machine to a network\n" in shell.output(
        "self-check"
    )


def test_a_folder_without_permission_does_not_hide_the_other_parts(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    def find_compiler() -> str:
        raise PermissionError(13, "Permission denied", "/usr/share/arduino/boards.txt")

    monkeypatch.setattr(self_check, "_find_compiler", find_compiler)
    lines = shell.output("self-check").splitlines()
    assert any("cannot read /usr/share/arduino/boards.txt: Permission denied" in line for line in lines)
    assert lines[-1].startswith(("yes  multicast", "     cannot join"))
