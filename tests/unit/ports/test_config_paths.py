from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rostether.ports.config_paths import devices_toml_path, known_boards_path


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has folders of its own")
def test_folders_of_the_xdg_specification() -> None:
    home = {"HOME": "/home/me"}
    assert devices_toml_path(home) == Path("/home/me/.config/rostether/devices.toml")
    assert known_boards_path(home) == Path("/home/me/.local/state/rostether/boards.json")
    assert devices_toml_path(home | {"XDG_CONFIG_HOME": "/x"}) == Path("/x/rostether/devices.toml")
    assert known_boards_path(home | {"XDG_STATE_HOME": "relative"}) == known_boards_path(home)
