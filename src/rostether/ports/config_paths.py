"""Where a user's settings and what we have learned are kept: the folders that each system has for that."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def devices_toml_path() -> Path:
    """Return `~/.config/rostether/devices.toml` (XDG_CONFIG_HOME; on Windows below APPDATA)."""
    return _folder("XDG_CONFIG_HOME", ".config", "APPDATA") / "devices.toml"


def known_boards_path() -> Path:
    """Return `~/.local/state/rostether/boards.json` (XDG_STATE_HOME; on Windows below LOCALAPPDATA)."""
    return _folder("XDG_STATE_HOME", ".local/state", "LOCALAPPDATA") / "boards.json"


def sensors_path() -> Path:
    """Return `~/.local/state/rostether/sensors.json` (XDG_STATE_HOME; on Windows below LOCALAPPDATA)."""
    return _folder("XDG_STATE_HOME", ".local/state", "LOCALAPPDATA") / "sensors.json"


def certificates_folder() -> Path:
    """Return `~/.local/state/rostether/tls` (XDG_STATE_HOME; on Windows below LOCALAPPDATA)."""
    return _folder("XDG_STATE_HOME", ".local/state", "LOCALAPPDATA") / "tls"


def recordings_folder() -> Path:
    """Return `~/.local/share/rostether/recordings` (XDG_DATA_HOME; on Windows below LOCALAPPDATA)."""
    return _folder("XDG_DATA_HOME", ".local/share", "LOCALAPPDATA") / "recordings"


def _folder(variable: str, below_home: str, on_windows: str) -> Path:
    given = os.environ.get(variable, "")
    # The XDG specification wants relative paths ignored.
    if given and Path(given).is_absolute():
        return Path(given) / "rostether"
    if sys.platform == "win32" and os.environ.get(on_windows):
        return Path(os.environ[on_windows]) / "rostether"
    home = os.environ.get("HOME") or "~"
    return Path(home).expanduser() / below_home / "rostether"
