from __future__ import annotations

from pathlib import Path

import pytest

from firmware.node.programs import write_test_library


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The client library with all bundled types and those of the tests."""
    return write_test_library(tmp_path_factory.mktemp("library"))
