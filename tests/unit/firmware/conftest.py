from __future__ import annotations

from pathlib import Path

import pytest

from unit.firmware.sketches import users_cache


@pytest.fixture(autouse=True)
def _own_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Use an empty home folder, without the user's sketchbook and packages."""
    monkeypatch.setenv("XDG_CACHE_HOME", users_cache())
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("ARDUINO_DIRECTORIES_USER", raising=False)
