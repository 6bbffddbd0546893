"""Lowers limits of a module for one input, so that a few KB reach and exceed them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType


@contextmanager
def lowered(module: ModuleType, **limits: object) -> Iterator[None]:
    """Set constants of a module to other values within the block. Raises an error for an unknown name."""
    before = {name: getattr(module, name) for name in limits}
    try:
        for name, value in limits.items():
            setattr(module, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(module, name, value)
