"""Thousands of invalid frames, each followed by a valid one that must be delivered."""

from __future__ import annotations

from pathlib import Path

import pytest

from effort import effort
from firmware.node.programs import build_program, run

FRAMES = effort(20_000, thorough=100_000)


@pytest.mark.gcc
@pytest.mark.timeout(300)
@pytest.mark.parametrize("compiler", ["gcc", "gcc-small"])
def test_the_node_works_after_any_frame(compiler: str, library: Path) -> None:
    program = build_program(compiler, "fuzz", library, "-Og")
    reported = run(program, "1", str(FRAMES), timeout_s=120)
    frames, delivered = [int(word) for word in reported.split() if word.isdigit()][:2]
    # Damage that leaves most messages intact, or none, would prove nothing.
    assert frames == FRAMES and 0.05 < delivered / frames < 0.8
