from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from rostether.simulation.simavr.compile import FLAGS, HEADERS, SOURCES

pytestmark = pytest.mark.simavr

COMPARED_BY_IT = ("decode.c", "instructions.c")


@pytest.fixture(scope="module")
def lockstep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = tmp_path_factory.mktemp("lockstep") / "lockstep"
    sources = [Path(__file__).parent / "lockstep.c", *(SOURCES / name for name in COMPARED_BY_IT)]
    command = [
        os.environ.get("CC", "cc"),
        *FLAGS,
        "-Werror",
        f"-I{SOURCES}",
        "-isystem",
        str(HEADERS),
        *map(str, sources),
        "-o",
        str(program),
        "-lsimavr",
    ]
    subprocess.run(command, check=True)
    return program


@pytest.mark.parametrize(("mcu", "rounds"), [("atmega328p", 20), ("atmega2560", 2), ("atmega32u4", 16)])
def test_each_instruction_does_what_the_simulators_does(lockstep: Path, mcu: str, rounds: int) -> None:
    result = subprocess.run([str(lockstep), mcu, str(rounds)], capture_output=True, text=True)
    lines = result.stdout.splitlines()
    assert [line for line in lines if not line.startswith("compared ")] == []
    assert result.returncode == 0
    counts = {line.split()[1]: int(line.split()[2]) for line in lines}
    assert len(counts) > 55
    assert [name for name, count in counts.items() if count < 100] == []
