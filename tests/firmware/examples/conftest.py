"""Fixtures of the examples' tests."""

from __future__ import annotations

import pytest


@pytest.fixture(params=["uno", "mega"])
def kind(request: pytest.FixtureRequest) -> str:
    """A board on which every example runs."""
    return str(request.param)


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    item.add_marker("simavr")
