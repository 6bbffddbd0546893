"""Marks of the end-to-end tests of the MeArm."""

from __future__ import annotations

import pytest


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    item.add_marker("simavr")
    item.add_marker(pytest.mark.timeout(300))
