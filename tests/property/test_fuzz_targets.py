"""A short, deterministic run of every fuzz target: the saved corpus, the seeds, and inputs derived
from them.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from fuzz import targets

pytestmark = pytest.mark.slow

GENERATED_INPUTS = 200
# Targets that take a millisecond or more for each input.
SLOW_INPUTS = {"session": 40, "rosbridge": 100, "foxglove": 100, "recordings": 100}


@pytest.mark.parametrize("name", targets.NAMES)
def test_guarantees_hold(name: str) -> None:
    target = targets.load(name)
    generated = itertools.islice(target.inputs(seed=4), SLOW_INPUTS.get(name, GENERATED_INPUTS))
    for data in itertools.chain(target.corpus(), generated):
        try:
            target.check(data)
        except Exception as error:  # noqa: BLE001 - the input belongs to the failure
            pytest.fail(f"{name} breaks a promise for {data!r:.500}: {type(error).__name__}: {error}")


def test_every_harness_is_a_target() -> None:
    files = (Path(targets.__file__).parent / "harness").glob("[a-z]*.py")
    assert {path.stem for path in files} - {"link_script"} == set(targets.NAMES)
