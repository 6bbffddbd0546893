"""The node on a scripted line: client/extras/tests/node, compiled for the host."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware.node.programs import COMPILERS, EXTRAS, build_program, run

CONCEPTS = [each.stem.removeprefix("test_") for each in sorted((EXTRAS / "node").glob("test_*.cpp"))]
COMPILER_NAMES = [
    pytest.param(name, marks=getattr(pytest.mark, name.partition("-")[0])) for name in COMPILERS
]


@pytest.mark.parametrize("concept", CONCEPTS)
@pytest.mark.parametrize("compiler", COMPILER_NAMES)
@pytest.mark.timeout(300)
def test_concept(compiler: str, concept: str, library: Path) -> None:
    run(build_program(compiler, "node", library), concept)
