"""A short run of every fuzz target, always the same: the kept corpus, the seeds, and changes of them."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))

from fuzz import targets
from fuzz.mutations import mutated

CHANGED_INPUTS = 500


@pytest.mark.parametrize("name", targets.NAMES)
def test_promises_hold(name: str) -> None:
    target = targets.load(name)
    corpus = target.corpus()
    for data in itertools.chain(corpus, itertools.islice(mutated(corpus, seed=4), CHANGED_INPUTS)):
        try:
            target.check(data)
        except Exception as error:  # noqa: BLE001 - the input belongs to the failure
            pytest.fail(f"{name} breaks a promise for {data!r:.500}: {type(error).__name__}: {error}")


def test_every_harness_is_a_target() -> None:
    files = (Path(targets.__file__).parent / "harness").glob("[a-z]*.py")
    assert {path.stem for path in files} - {"link_script"} == set(targets.NAMES)
