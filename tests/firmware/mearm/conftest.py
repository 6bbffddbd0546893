"""Fixtures of the MeArm end to end."""

from __future__ import annotations

import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    for item in items:
        if item.path.parent.parts[-2:] == ("firmware", "mearm"):
            item.add_marker("simavr")
            item.add_marker(pytest.mark.timeout(300))
