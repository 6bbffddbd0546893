"""`make demo` ends as the demo does."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[4]


@pytest.mark.parametrize(("status", "made"), [(130, 0), (0, 0), (3, 2)])
def test_an_interrupted_demo_is_not_an_error_of_make(status: int, made: int, tmp_path: Path) -> None:
    program = tmp_path / "bin" / "rostether"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\nexit {status}\n")
    program.chmod(0o755)
    installed = tmp_path / ".installed"
    installed.touch()
    os.utime(installed, (time.time() + 1e6,) * 2)
    run = subprocess.run(
        ["make", "-C", REPOSITORY, "demo", f"VENV={tmp_path}"], capture_output=True, text=True, check=False
    )
    assert run.returncode == made
    assert ("Error 3" in run.stderr) == (status == 3)
    # The path of the temporary folder may contain the number alone.
    assert "Error 130" not in run.stderr
