"""Marks of the tests of boards in ROS 2."""

from __future__ import annotations

import pytest


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    item.add_marker("simavr")
