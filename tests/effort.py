"""The number of inputs that a test tries: a few in each run, many with THOROUGH=1 before a release."""

from __future__ import annotations

import os
from typing import TypeVar

T = TypeVar("T")


def effort(quick: T, thorough: T) -> T:
    """Return `thorough` with THOROUGH=1 in the environment, else `quick`."""
    return thorough if os.environ.get("THOROUGH") == "1" else quick
