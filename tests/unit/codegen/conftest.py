from __future__ import annotations

import pytest

from rostether.codegen.arduino_library import WrittenLibrary, write_library
from rostether.msgdef.registry import Registry
from unit.codegen.hostile import write_definitions


@pytest.fixture(scope="session")
def hostile_registry(tmp_path_factory: pytest.TempPathFactory) -> Registry:
    """All bundled types, and the hostile ones."""
    return Registry([write_definitions(tmp_path_factory.mktemp("definitions"))])


@pytest.fixture(scope="session")
def hostile_library(hostile_registry: Registry, tmp_path_factory: pytest.TempPathFactory) -> WrittenLibrary:
    """The library with all these types."""
    return write_library(tmp_path_factory.mktemp("library"), hostile_registry)
