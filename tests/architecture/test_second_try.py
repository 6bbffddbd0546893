"""A test that fails while other tests run is tried again, and the end of the run lists it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

TESTS = Path(__file__).parents[1]
TEST_MODULE = """
import pytest

TRIES = []

@pytest.fixture
async def number():
    TRIES.append(1)
    yield len(TRIES)

@pytest.fixture(scope="module")
def place():
    yield TRIES.copy()

def test_first(place):
    pass

async def test_late(place, number):
    assert number == 2, "too late"
    assert place, "not made again"

def test_wrong():
    assert False, "never true"

def test_good():
    pass
"""


@pytest.mark.parametrize("processes", [0, 1])
def test_a_test_that_runs_beside_others_is_tried_twice(processes: int, tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(TEST_MODULE)
    (tmp_path / "pytest.ini").write_text("[pytest]\nasyncio_mode = auto\n")
    environment = {name: value for name, value in os.environ.items() if "XDIST" not in name}
    finished = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "second_try", "-n", str(processes), "-rf", "test_it.py"],
        cwd=tmp_path,
        env=environment | {"PYTHONPATH": str(TESTS)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    output = finished.stdout
    assert finished.returncode == 1
    assert f"{2 - processes} failed, {2 + processes} passed" in output
    assert ("= second tries =" in output) == bool(processes)
    assert output.count("test_it.py::test_late: ") == processes
    assert ("too late" in output.partition("= second tries =")[2]) == bool(processes)
