"""Reads the state table that a module's docstring draws, so that a test can compare it with the code."""

from __future__ import annotations

import re
from collections.abc import Iterator
from types import ModuleType

_CELL = re.compile(r"[A-Z][A-Z_]+\Z|any\Z")


def drawn_transitions(module: ModuleType) -> Iterator[tuple[str, str, str, str]]:
    """Yield (state, input, next state, fourth column) of each row; rows for `any` state included."""
    assert module.__doc__ is not None
    for line in module.__doc__.splitlines():
        cells = re.split(r"\s{2,}", line.strip())
        if len(cells) >= 3 and all(_CELL.match(cell) for cell in cells[:3]):
            yield cells[0], cells[1], cells[2], cells[3] if len(cells) > 3 else ""
