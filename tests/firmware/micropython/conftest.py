"""Fixtures of the tests of the MicroPython client library."""

from __future__ import annotations

from pathlib import Path

import pytest

from rostether.codegen.micropython_library import write_micropython_library
from rostether.msgdef.registry import Registry

FOLDER = Path(__file__).parent


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client library with the messages that the tests' programs use."""
    packages = ["std_msgs", "std_srvs", "sensor_msgs"]
    return write_micropython_library(tmp_path_factory.mktemp("library"), Registry(), packages=packages).path


def pytest_itemcollected(item: pytest.Item) -> None:
    """Everything in this folder runs MicroPython."""
    if item.path.parent == FOLDER:
        item.add_marker("micropython")
