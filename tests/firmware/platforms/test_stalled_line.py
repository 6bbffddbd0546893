from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from firmware.platforms.programs import NODE, compile_program


@pytest.mark.gcc
def test_the_node_waits_once_for_a_line_that_accepts_nothing(library: Path, tmp_path: Path) -> None:
    """If the host sleeps, the robot must not wait for each message."""
    program = compile_program(["g++", "-O1"], [NODE / "stalled_line.cpp"], library, tmp_path / "line")
    completed = subprocess.run([program], check=False)
    assert completed.returncode == 0, f"check {completed.returncode} of stalled_line.cpp failed"
