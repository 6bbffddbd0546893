"""The tests that were collected do not slow down the garbage collector."""

from __future__ import annotations

import gc


def test_collected_tests_are_frozen() -> None:
    assert gc.get_freeze_count() > len(gc.get_objects())
