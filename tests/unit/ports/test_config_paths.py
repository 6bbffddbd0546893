from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.ports.config_paths import devices_toml_path, known_boards_path


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has folders of its own")
def test_folders_of_the_xdg_specification(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/me")
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    assert devices_toml_path() == Path("/home/me/.config/rostether/devices.toml")
    assert known_boards_path() == Path("/home/me/.local/state/rostether/boards.json")
    monkeypatch.setenv("XDG_CONFIG_HOME", "/x")
    assert devices_toml_path() == Path("/x/rostether/devices.toml")
