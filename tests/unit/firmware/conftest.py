from __future__ import annotations

from pathlib import Path

import pytest

from unit.firmware.sketches import shared_cache


@pytest.fixture(autouse=True)
def _own_home(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No sketchbook and no packages of the user's; objects are compiled once in a run."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared_cache(tmp_path_factory)))
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("ARDUINO_DIRECTORIES_USER", raising=False)
