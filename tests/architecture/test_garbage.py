"""The collected tests do not slow down the garbage collector, which stays enabled during the tests."""

from __future__ import annotations

import gc

import pytest

from frozen_objects import FROZEN_OBJECTS


def test_collected_tests_are_frozen(pytestconfig: pytest.Config) -> None:
    frozen, others = pytestconfig.stash[FROZEN_OBJECTS]
    assert frozen > others
    assert gc.isenabled()
