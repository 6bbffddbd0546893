"""Limits of a module made small for one input, so that a few KB reach what lies at them and behind them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType


@contextmanager
def lowered(module: ModuleType, **limits: object) -> Iterator[None]:
    """Give constants of a module other values within the block; a name that it does not have is an error."""
    before = {name: getattr(module, name) for name in limits}
    try:
        for name, value in limits.items():
            setattr(module, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(module, name, value)
