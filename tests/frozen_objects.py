"""The number of objects that `conftest` froze for the garbage collector, and of those that it did not
freeze.
"""

from __future__ import annotations

import pytest

FROZEN_OBJECTS = pytest.StashKey[tuple[int, int]]()
