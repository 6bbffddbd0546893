"""Where `conftest` notes how many objects it has kept from the garbage collector, and how many it has not."""

from __future__ import annotations

import pytest

FROZEN_OBJECTS = pytest.StashKey[tuple[int, int]]()
