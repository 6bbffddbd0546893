"""Fixtures of boards in ROS 2: one process serves the boards of a file, and one peer uses them."""

from __future__ import annotations

import pytest


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    item.add_marker("simavr")
