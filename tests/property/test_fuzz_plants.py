"""The fuzzers find every planted fault, which shows that `make fuzz` can find faults."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from fuzz import targets
from fuzz.plants import PLANTS, Plant

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
# CPU time. With this seed, each fault is found in a few seconds; with any seed, in 20 s.
SECONDS, SEED = "20", "4"


@pytest.mark.parametrize("plant", PLANTS.values(), ids=PLANTS.keys())
def test_a_planted_fault_is_found(plant: Plant) -> None:
    command = [sys.executable, "-m", "fuzz", plant.target, "--plant", plant.name]
    found = subprocess.run(
        [*command, "--seconds", SECONDS, "--seed", SEED],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 1, found.stdout + found.stderr
    assert f"{plant.target} breaks a promise" in found.stdout, found.stdout + found.stderr


def test_every_target_has_a_plant() -> None:
    assert {plant.target for plant in PLANTS.values()} == set(targets.NAMES)
