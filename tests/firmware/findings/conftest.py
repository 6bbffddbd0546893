from __future__ import annotations

import pytest


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Everything in this folder needs an AVR compiler and simulated boards."""
    for item in items:
        if "findings" in item.path.parts and "firmware" in item.path.parts:
            item.add_marker("simavr")
