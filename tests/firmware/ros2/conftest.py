"""Fixtures of boards in ROS 2: the boards of a file are served by one process, and seen by one peer."""

from __future__ import annotations

import pytest


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    item.add_marker("simavr")
